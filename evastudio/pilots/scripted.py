"""Scripted demonstrators: programs that stand in for a person where none can drive.

Each wants what the scene's `intention` says, and then does it as well as its traits allow: late,
shakily, sometimes wrongly, or with keys. **No person is behind them**; takes they record say so.
Any scene with an `intention` can be driven by them.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from evastudio.errors import not_found
from evastudio.pilots.astar import AStarPilot
from evastudio.pilots.chance import normals, uniforms
from evastudio.pilots.straight import StraightPilot
from evastudio.pilots.traits import STYLES, Traits
from evastudio.world.rollout import Memory, Pilot
from evastudio.world.scene import Scene
from evastudio.world.snapshot import AnyArray, Snapshot
from evastudio.world.spaces import Array, Box

TREMOR_MEMORY = 0.8
"""Share of the hand's unsteadiness that is left after a step: a tremble, not noise."""

_DELAY, _TREMOR, _MISTAKE, _REST = range(4)


@dataclass(frozen=True)
class ScriptedPilot(Pilot):
    """A scripted demonstrator with `traits`. All its luck follows from each world's seed."""

    traits: Traits
    name: str = "scripted"

    def begin(self, scene: Scene, seeds: Sequence[int]) -> Memory:
        worlds, shape = len(seeds), (*scene.characters, scene.action.size)
        return {
            "seed": np.array([seed % 2**64 for seed in seeds], dtype=np.uint64),
            "step": np.zeros(worlds, dtype=np.int64),
            "tremor": np.zeros((worlds, *shape)),
            "wrong": np.zeros(worlds, dtype=np.int64),
            "resting": np.zeros(worlds, dtype=np.int64),
            "owed": np.zeros((worlds, *shape)),
            "done": np.zeros((worlds, self._longest + 1, *shape)),
        }

    @property
    def _longest(self) -> int:
        return int(self.traits.delay_steps + self.traits.delay_jitter_steps)

    def act(self, scene: Scene, snapshot: Snapshot, memory: Memory) -> tuple[Array, Memory]:
        traits = self.traits
        after = dict(memory)
        seen = self._see(scene, snapshot, after)
        middle = (scene.action.high + scene.action.low) / 2
        half = (scene.action.high - scene.action.low) / 2
        # From here on in shares of half the range.
        meant = want = (scene.intention(seen, **traits.intention) - middle) / half
        seed, step = memory["seed"], memory["step"]
        wrong = self._burst(after, "wrong", traits.mistakes_per_minute, traits.mistake_steps, scene)
        want = np.where(_beside(wrong, want), -want, want)
        rests = self._burst(
            after, "resting", traits.indecision_per_minute, traits.indecision_steps, scene
        )
        nothing = (scene.action.clip(np.zeros(scene.action.size)) - middle) / half
        want = np.where(_beside(rests, want), nothing, want)
        last = memory["done"][:, 0]
        turns = isinstance(scene.action, Box)  # a symbol is chosen as a whole
        if turns and traits.smoothing:
            want = traits.smoothing * last + (1.0 - traits.smoothing) * want
        if turns and traits.tremor:
            fresh = normals(seed, step, _TREMOR, want[0].size).reshape(want.shape)
            fresh = fresh * (traits.tremor * np.sqrt(1.0 - TREMOR_MEMORY**2))
            after["tremor"] = TREMOR_MEMORY * memory["tremor"] + fresh
            want = want + after["tremor"]
        want = np.clip(want, -1.0, 1.0)
        if turns and traits.keys:
            want = self._press(scene, want, last, after)
        want = np.where(_steered(scene), want, np.clip(meant, -1.0, 1.0))
        after["done"] = np.concatenate([want[:, None], memory["done"][:, :-1]], axis=1)
        after["step"] = step + 1
        return middle + want * half, after

    def _see(self, scene: Scene, snapshot: Snapshot, memory: dict[str, AnyArray]) -> Snapshot:
        """What is believed to be the present: the past, foreseen as far as anticipation goes."""
        if self._longest == 0:
            return snapshot
        past = {}
        for name, array in snapshot.moving.items():
            key = f"past.{name}"
            old = memory.get(key)
            if old is None:
                old = np.repeat(array[:, None], self._longest + 1, axis=1)
            past[name] = memory[key] = np.concatenate([array[:, None], old[:, :-1]], axis=1)
        step = memory["step"]
        second = np.asarray(step * scene.dt_s, dtype=np.int64)
        wander = uniforms(memory["seed"], second, _DELAY)[:, 0] * 2.0 - 1.0
        wander = np.rint(wander * self.traits.delay_jitter_steps)
        delay = np.clip(self.traits.delay_steps + wander, 0, self._longest).astype(np.int64)
        delay = np.minimum(delay, step)
        world = np.arange(snapshot.worlds)
        seen = Snapshot(snapshot.fixed, {name: old[world, delay] for name, old in past.items()})
        foreseen = np.rint(self.traits.anticipation * delay).astype(np.int64)
        middle = (scene.action.high + scene.action.low) / 2
        half = (scene.action.high - scene.action.low) / 2
        for ahead in range(int(foreseen.max(initial=0))):
            # `done` has the latest action first; the one that followed the sight is at delay - 1.
            own = memory["done"][world, np.maximum(delay - 1 - ahead, 0)]
            seen = _where(ahead < foreseen, scene.step(seen, middle + own * half), seen)
        return seen

    def _burst(
        self, memory: dict[str, AnyArray], name: str, per_minute: float, steps: int, scene: Scene
    ) -> NDArray[np.bool_]:
        """Which worlds are in a burst called `name` now; counts it down in `memory`."""
        if not per_minute or not steps:
            return np.zeros(len(memory["step"]), dtype=np.bool_)
        channel = _MISTAKE if name == "wrong" else _REST
        luck = uniforms(memory["seed"], memory["step"], channel)[:, 0]
        begins = luck < per_minute * scene.dt_s / 60.0
        left = np.where(begins & (memory[name] == 0), steps, memory[name])
        memory[name] = np.maximum(left - 1, 0)
        return np.asarray(left > 0)

    def _press(self, scene: Scene, want: Array, last: Array, memory: dict[str, AnyArray]) -> Array:
        """The deflection that held or released keys give, nearest in the mean to `want`.

        What the keys have failed to give so far is owed. A key is held while, with what its
        release would still add on the way back to rest, something is owed.
        """
        ramps = {control.field: control.ramp_s for control in scene.controls}
        pace = np.array(
            [scene.dt_s / max(ramps.get(name, 0.0), scene.dt_s) for name in scene.action.names]
        )
        owed = memory["owed"] + want
        coast = np.sign(last) * last**2 / (2.0 * pace)
        rest = owed - coast
        held = np.where(last != 0.0, rest * np.sign(last) > 0.0, False)
        held |= np.abs(rest) > self.traits.key_patience
        aim = np.where(held, np.sign(rest), 0.0)
        given = last + np.clip(aim - last, -pace, pace)
        # Debts fade: nobody makes up for a turn missed a second ago.
        memory["owed"] = np.clip((owed - given) * 0.9, -6.0, 6.0)
        return np.asarray(given)


def _where(mask: NDArray[np.bool_], yes: Snapshot, no: Snapshot) -> Snapshot:
    """World by world one or the other; what is fixed must be the same in both."""
    moving = {}
    for name, array in yes.moving.items():
        moving[name] = np.where(_beside(mask, array), array, no.moving[name])
    return Snapshot(no.fixed, moving)


def _steered(scene: Scene) -> NDArray[np.bool_]:
    """Which components of the action (m,) a hand gives, well or badly: those that controls move."""
    fields = {control.field for control in scene.controls}
    if not fields or not isinstance(scene.action, Box):
        return np.ones(scene.action.size, dtype=np.bool_)
    return np.array([name in fields for name in scene.action.names])


def _beside(mask: NDArray[np.bool_], array: AnyArray) -> NDArray[np.bool_]:
    """`mask` (worlds,) with as many axes as `array` (worlds, ...)."""
    return mask.reshape(-1, *(1 for _ in array.shape[1:]))


PROGRAMS: Mapping[str, Callable[[], Pilot]] = {
    StraightPilot.name: StraightPilot,
    AStarPilot.name: AStarPilot,
}
"""Pilots that are shown nothing and are nobody's stand-in."""


def pilot_names() -> list[str]:
    """Every name that `find_pilot` answers to."""
    return [*PROGRAMS, *(f"scripted:{style}" for style in STYLES)]


def is_program(name: str) -> bool:
    """Whether `name` is for `find_pilot`, and not the name of a policy."""
    return name in PROGRAMS or name.startswith("scripted:")


def suits(name: str, scene: Scene) -> bool:
    """Whether the program `name` has something to do with `scene`: it plans through its course,
    or its traits are such as the scene's intentions have."""
    if name == AStarPilot.name:
        return type(scene).course is not Scene.course
    style = STYLES.get(name.removeprefix("scripted:"))
    return style is None or style.suit(scene)


def find_pilot(name: str, **traits: Any) -> Pilot:
    """The pilot of that name, with `traits` (fields of `Traits`) changed where it is scripted.

    Raises NotFoundError for an unknown pilot or trait, InvalidInputError for a bad value.
    """
    if name not in pilot_names():
        raise not_found("pilot", name, pilot_names())
    known = [] if name in PROGRAMS else [field.name for field in fields(Traits)]
    for trait in traits:
        if trait not in known:
            raise not_found("trait", trait, known, f"of pilot {name!r}")
    if name in PROGRAMS:
        return PROGRAMS[name]()
    style = STYLES[name.removeprefix("scripted:")]
    return ScriptedPilot(replace(style, **traits), name)
