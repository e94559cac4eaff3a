"""The scene contract: a character, its world, what it perceives and what it can do."""

from __future__ import annotations

import json
from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from evastudio.errors import InvalidInputError, NotFoundError, not_found
from evastudio.world.bodies import Body, Camera, Look, Mesh
from evastudio.world.cast import of_lead
from evastudio.world.course import Course
from evastudio.world.snapshot import AnyArray, Snapshot, stack
from evastudio.world.spaces import Array, Box, Space

RUNNING = "running"
"""The first entry of every scene's `outcomes`."""


@dataclass(frozen=True)
class Option:
    """A number of a scene that its user chooses, such as how crowded it is."""

    name: str
    label: str
    """What a person reads beside the slider."""
    default: float
    low: float
    high: float
    step: float
    help: str


@dataclass(frozen=True)
class Control:
    """Which keys move one component of the action, or choose one of its symbols."""

    field: str
    """Name of the action's field, or of the symbol."""
    label: str
    """What a person reads: 'turn left and right'."""
    negative: tuple[str, ...]
    """Keyboard codes (KeyboardEvent.code) that push it down."""
    positive: tuple[str, ...]
    """Keyboard codes that push it up."""
    ramp_s: float
    """Seconds from rest to full deflection while a key is held, and back when released."""
    latched: bool = False
    """What is held when the decision falls counts, and a tap since the last one; not the mean over
    the step. For decisions so far apart that a person presses in time for each."""
    reach: float = 1.0
    """Deflection that a held key comes to, a share of the full one."""


@dataclass(frozen=True)
class Signal:
    """What an animator does to a world besides guiding the character: let a boulder fall.

    It is part of the lead's next action, so that takes hold it and replay with it.
    """

    name: str
    label: str
    """What a person reads: 'let the boulder fall'."""
    key: str
    """Keyboard code that gives it."""
    field: str
    """Component of the action that is then at its highest."""
    place: tuple[str, str] | None = None
    """Components that take where on the ground it is meant, x and y; None where it has no place."""


MARK = "mark"
"""Name of the signal by which an animator marks the moment of a switch, where a scene has it."""


@dataclass(frozen=True)
class Sign:
    """What can be told of a character at any moment, and a switch between policies may hang on."""

    name: str
    label: str
    """What a person reads: 'the boulder has hit the ground', 'the distance to the boulder'."""
    unit: str | None = None
    """Of a number; None for an event, which is 1 where it is so and 0 where not."""


@dataclass(frozen=True)
class Percept:
    """What a batch of characters perceives."""

    states: Array
    """Shape (worlds, state size), or (worlds, characters, state size)."""
    frame: AnyArray
    """Shape (worlds, ...), with an axis for characters where states have one: what `to_own` and
    `to_world` need to turn actions, and nothing else."""


class Perception(ABC):
    """A named way to turn a snapshot into a state, and actions between frames."""

    name: ClassVar[str]
    summary: ClassVar[str]
    """One sentence for people who choose between perceptions."""
    state: Box
    """The state, field by field."""
    action: Space | None = None
    """What is chosen under it, in the character's own frame; None: what the scene's action is."""

    @abstractmethod
    def perceive(self, snapshot: Snapshot) -> Percept:
        """The states of all worlds, and the frames their actions are given in."""

    def applies(self, snapshot: Snapshot) -> NDArray[np.bool_]:
        """In which worlds a demonstration is about what this perception shows, (worlds,).

        Other moments of a take are not learned from under it.
        """
        return np.ones(snapshot.worlds, dtype=np.bool_)

    def to_own(self, frame: AnyArray, actions: Array) -> Array:
        """`actions` (worlds, m) of the world, in the character's own frame."""
        return actions

    def to_world(self, frame: AnyArray, actions: Array) -> Array:
        """`actions` (worlds, m) of the character's own frame, in the world's."""
        return actions


class Scene(ABC):
    """A character in a world. Subclass it in one file; `evastudio check FILE` tests that file.

    A scene is a pure description: no clock, no drawing, no files, and no randomness but the
    generator given to `reset`. Its methods work on batches of worlds (see `Snapshot`).
    """

    name: ClassVar[str]
    """Lower-case identifier, unique in a workspace."""
    title: ClassVar[str]
    """What a person reads."""
    version: ClassVar[int]
    """Raised whenever the same seed and actions would give other snapshots."""
    dt_s: ClassVar[float]
    """The decision step, seconds."""
    render_hz: ClassVar[float]
    """How often a view should draw it."""
    outcomes: ClassVar[tuple[str, ...]]
    """What can become of a world; the first is 'running', the others end it."""
    successes: ClassVar[frozenset[str]]
    """The outcomes that end a world well."""
    options: ClassVar[tuple[Option, ...]] = ()
    controls: ClassVar[tuple[Control, ...]] = ()
    signals: ClassVar[tuple[Signal, ...]] = ()
    signs: ClassVar[tuple[Sign, ...]] = ()
    """What `notice` tells. `x` and `y`, where a scene has them, say where on the ground one is."""
    action: Space
    """What the character can do, in the world's frame: real numbers or symbols."""
    perceptions: Mapping[str, Perception]
    """By name; the first is the default."""
    look: ClassVar[Look]
    characters: tuple[int, ...] = ()
    """Empty where one character acts alone. Where many share a world, how many, and actions have
    the shape (worlds, characters, action size), states likewise, and snapshots hold `lead`
    (worlds,): which of them the animator guides."""

    def __init__(self, **values: float) -> None:
        """A scene with `values` for its options; the others take their defaults.

        Raises NotFoundError for an unknown option, InvalidInputError for a value out of range.
        """
        known = {option.name: option for option in self.options}
        chosen = {option.name: option.default for option in self.options}
        for name, value in values.items():
            if name not in known:
                raise not_found("option", name, known, f"of scene {self.name!r}")
            option = known[name]
            try:
                number = float(value)
            except (TypeError, ValueError):
                number = float("nan")
            if not option.low <= number <= option.high:
                raise InvalidInputError(
                    f"Option {name!r} is {value!r}; it must be a number from {option.low:g} to "
                    f"{option.high:g}."
                )
            chosen[name] = number
        self.values: Mapping[str, float] = chosen

    @abstractmethod
    def reset(self, rng: np.random.Generator, worlds: int) -> Snapshot:
        """`worlds` new worlds, every random number drawn from `rng`."""

    @abstractmethod
    def step(self, snapshot: Snapshot, actions: Array) -> Snapshot:
        """The worlds one decision step later. `actions` has shape (worlds, action size), with an
        axis for `characters` between where there are many."""

    @abstractmethod
    def outcome(self, snapshot: Snapshot) -> NDArray[np.int64]:
        """For each world the index into `outcomes`, 0 while it runs. Shape (worlds,)."""

    @abstractmethod
    def progress(self, snapshot: Snapshot) -> Array:
        """How far each world has come, 0 to 1. Shape (worlds,)."""

    @abstractmethod
    def meshes(self) -> Mapping[str, Mesh]:
        """The meshes that `bodies` names."""

    @abstractmethod
    def bodies(self, snapshot: Snapshot) -> Sequence[Body]:
        """What to draw of the first world."""

    @abstractmethod
    def camera(self, snapshot: Snapshot) -> Camera:
        """Where the animator sees the first world from, unless they choose another camera."""

    def cameras(self, snapshot: Snapshot) -> Mapping[str, Camera]:
        """Where the first world can be seen from, by what a person reads: 'overview'.

        The first is where one begins. Always of the same names.
        """
        return {"chase": self.camera(snapshot)}

    # -- what a flight is measured by ----------------------------------------------------------

    clear_m: ClassVar[float] = 10.0
    """A clearance above this is as good as any."""
    near_m: ClassVar[float] = 1.0
    """A clearance below this is a near miss."""

    def whereabouts(self, snapshot: Snapshot) -> Array:
        """Where the character is (of many, the lead), shape (worlds, 2) or (worlds, 3), metres.

        The moving array `position`; a scene that has none stays where it is, or says otherwise.
        """
        position = snapshot.moving.get("position")
        if position is None:
            return np.zeros((snapshot.worlds, 2))
        return of_lead(snapshot, position)

    def clearance(self, snapshot: Snapshot) -> Array:
        """Metres from the character (of many, the lead) to the nearest thing it must not touch.

        Shape (worlds,); infinite where there is none within `clear_m`, or nothing to touch at all.
        """
        return np.full(snapshot.worlds, np.inf)

    def measures(self, moments: Snapshot, actions: Array) -> dict[str, float]:
        """Figures of the scene's own for one world from its beginning.

        `moments` are its snapshots in order, before each decision, along the axis of worlds;
        `actions` (moments, ..., action size) what was chosen.
        """
        return {}

    def intention(self, snapshot: Snapshot, **traits: float) -> Array:
        """What a skilled demonstrator would want to do now, shape (worlds, action size).

        Scripted demonstrators build on it. `traits` are numbers that the scene understands.
        Raises NotFoundError where a scene has none.
        """
        raise NotFoundError(
            f"Scene {self.name!r} has no scripted demonstrator; choose another pilot or another "
            "scene."
        )

    def course(self, snapshot: Snapshot) -> Course:
        """The worlds as a planner searches them.

        Raises NotFoundError where a scene is no course.
        """
        raise NotFoundError(
            f"Scene {self.name!r} is no course that astar could plan a way through; choose another "
            "pilot or another scene."
        )

    def retraced(self, paths: Array, goals: Array, ground: Array) -> tuple[Snapshot, Array]:
        """A world in which characters can go as they were recorded, and how they do it.

        `paths` (1 + moments, N, 2) is where they are at each step, NaN where they are not there;
        the first row is a step earlier and tells how fast they come. `goals` (N, 2) is where each
        ends up, `ground` (points, 2) where one can walk. The first of them leads. Gives the first
        moment of one world, and actions (moments - 1, N, m).
        Raises NotFoundError where nobody in the scene can go as people do.
        """
        raise NotFoundError(
            f"In scene {self.name!r} nobody can walk as people were recorded; choose another scene."
        )

    def notice(self, snapshot: Snapshot) -> Array:
        """What each of `signs` is now, shape (worlds, signs), finite; with an axis for
        `characters` between where there are many."""
        return np.zeros((snapshot.worlds, *self.characters, 0))

    def instead(self, snapshot: Snapshot, actions: Array) -> Array:
        """What everybody does instead where their `actions` would only be in vain.

        A guarded pilot asks this. The rule is the scene's and knows no policy; where nobody can
        stand in another's way, `actions` as they are.
        """
        return actions

    def interpolate(self, before: Snapshot, after: Snapshot, fraction: float) -> Snapshot:
        """Between two successive snapshots, for drawing only; `fraction` runs from 0 to 1."""
        mixed: dict[str, AnyArray] = {}
        for name, array in after.moving.items():
            old = before.moving[name]
            if np.issubdtype(array.dtype, np.floating):
                mixed[name] = old + (array - old) * fraction
            else:
                mixed[name] = array
        return Snapshot(after.fixed, mixed)

    # -- what the studio itself needs of any scene ---------------------------------------------

    def chosen(self, perception: Perception) -> Space:
        """What is chosen under `perception`: its own kind of action, or the scene's."""
        return self.action if perception.action is None else perception.action

    def perception(self, name: str | Perception | None = None) -> Perception:
        """The perception of that name, the default, or the one given. Raises NotFoundError."""
        if isinstance(name, Perception):
            return name
        if name is None:
            return next(iter(self.perceptions.values()))
        if name not in self.perceptions:
            raise not_found("perception", name, self.perceptions, f"of scene {self.name!r}")
        return self.perceptions[name]

    def worlds(self, seeds: Sequence[int]) -> Snapshot:
        """One new world for each seed. A world depends on its own seed alone."""
        return stack([self.reset(np.random.default_rng(seed), 1) for seed in seeds])

    def identity(self) -> dict[str, Any]:
        """What must be equal for two worlds of the same seed to be equal."""
        return {"name": self.name, "version": self.version, "options": dict(self.values)}

    def __repr__(self) -> str:
        return f"<scene {json.dumps(self.identity())}>"


def world_seeds(seed: int, count: int) -> list[int]:
    """`count` seeds of worlds that follow from `seed`; more of them begin with the same ones.

    They have 53 bits, so that they survive JSON and JavaScript.
    """
    words = np.random.SeedSequence(seed).generate_state(count, np.uint64)
    return [int(word >> np.uint64(11)) for word in words]
