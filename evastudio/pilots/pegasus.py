"""PEGASUS: search for a policy that does well in a few fixed worlds, with no demonstration.

Ng, Jordan, "PEGASUS: a policy search method for large MDPs and POMDPs", 2000; the paper compares
with it in section 4.1 and table 2. All chance is drawn beforehand: the worlds are fixed, so that a
policy's score is a function of its weights alone and can be climbed. The policy is a small neural
network on a perception of the scene; scenes, steps and outcomes are those of everybody else.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any, Protocol

import joblib
import numpy as np
from numpy.typing import NDArray

from evastudio.errors import ConflictError, InvalidInputError
from evastudio.learning.mlp import MLPPolicy
from evastudio.learning.policy import Policy
from evastudio.pilots.straight import StraightPilot
from evastudio.world.rollout import Memory, Pilot, roll_out
from evastudio.world.scene import Perception, Scene, world_seeds
from evastudio.world.snapshot import Snapshot
from evastudio.world.spaces import Array, Box

OPTIMISERS = ("cma-es", "hill-climbing")
LARGEST = 20.0
"""No weight goes beyond: a unit of tanh says nothing new there."""
CHUNK = 384
"""Worlds flown in one batch, to bound memory. Results do not depend on it."""
FEW = 4
"""Networks that a process is given at once where several have a share of them."""


@dataclass(frozen=True)
class Round:
    """Where the search stood after a round of trials."""

    score: float
    """The best so far, over the fixed worlds."""
    trials: int
    """Networks tried so far."""
    decisions: int
    """Decisions flown so far."""
    cpu_s: float
    """Of the process that searches, without those it has help from."""
    wall_s: float
    network: MLPPolicy
    """The best so far."""


@dataclass(frozen=True)
class Pegasus:
    """How to search."""

    optimiser: str = "cma-es"
    """One of OPTIMISERS."""
    hidden: int = 8
    """Hidden units of the network."""
    scenarios: int = 24
    """Fixed worlds that every network is tried in."""
    horizon_s: float = 24.0
    """How long it is tried in each."""
    population: int = 32
    """Networks tried in a round."""
    rounds: int = 30
    spread: float = 0.15
    """Of the weights that are tried first; for hill climbing, of the changes."""
    loss: float = 0.5
    """What it costs to end without success within the horizon; progress counts from 0 to 1."""
    calm: float = 0.5
    """What the mean change of action, as a share of its range, costs. The paper found such rewards
    hard to tune for looks."""
    seed: int = 0
    """Decides the worlds and what is tried."""

    def __post_init__(self) -> None:
        if self.optimiser not in OPTIMISERS:
            raise InvalidInputError(
                f"The optimiser is {self.optimiser!r}; it must be one of {', '.join(OPTIMISERS)}."
            )
        for name in ("hidden", "scenarios", "population", "rounds"):
            if not isinstance(getattr(self, name), int) or getattr(self, name) < 1:
                raise InvalidInputError(
                    f"{name} is {getattr(self, name)!r}; it must be a whole number from 1 on."
                )
        for name in ("horizon_s", "spread"):
            value = getattr(self, name)
            if not isinstance(value, (int, float)) or not 0.0 < value < 1e6:
                raise InvalidInputError(f"{name} is {value!r}; it must be a number above 0.")
        for name in ("loss", "calm"):
            value = getattr(self, name)
            if not isinstance(value, (int, float)) or not 0.0 <= value < 1e6:
                raise InvalidInputError(f"{name} is {value!r}; it must be a number from 0 on.")
        if self.optimiser == "cma-es" and self.population < 4:
            raise InvalidInputError(f"population is {self.population}; CMA-ES needs 4 or more.")

    def search(
        self,
        scene: Scene,
        perception: str | Perception | None = None,
        *,
        watch: Callable[[Round], None] | None = None,
        n_jobs: int = 1,
        clock: Callable[[], float] = time.perf_counter,
        cpu: Callable[[], float] = time.process_time,
    ) -> Policy:
        """The best policy found in `rounds`. `watch` hears each; what it raises ends the search.

        A round's networks are tried in `n_jobs` processes, by joblib; what is found does not depend
        on how many.

        Raises InvalidInputError for a scene of symbols or of many characters, ConflictError where
        CMA-ES is asked for and not installed.
        """
        view = scene.perception(perception)
        action = scene.chosen(view)
        if not isinstance(action, Box) or scene.characters:
            raise InvalidInputError(
                f"PEGASUS searches for actions of numbers for one character, and scene "
                f"{scene.name!r} has another kind."
            )
        course = _Course(self, scene, view, action)
        asking = (_Evolution if self.optimiser == "cma-es" else _Climb)(self, course.size)
        best, top, decisions = np.zeros(course.size), -np.inf, 0
        began, spent = clock(), cpu()
        for number in range(1, self.rounds + 1):
            tried = asking.ask()
            scores, flown = course.scores(tried, n_jobs)
            decisions += flown
            asking.tell(tried, scores)
            if scores.max() > top:
                best, top = tried[scores.argmax()], float(scores.max())
            if watch is not None:
                watch(
                    Round(
                        score=top,
                        trials=number * self.population,
                        decisions=decisions,
                        cpu_s=cpu() - spent,
                        wall_s=clock() - began,
                        network=course.network(best),
                    )
                )
        return Policy(
            learner=course.network(best),
            scene=scene.identity(),
            perception=view.name,
            state=view.state,
            action=action,
            pairs=0,
            fingerprint="",
            extra={"pegasus": {**self.__dict__, "score": top, "decisions": decisions}},
        )


class _Course:
    """The fixed worlds, and how well networks do in them."""

    def __init__(self, settings: Pegasus, scene: Scene, view: Perception, action: Box) -> None:
        self.settings, self.scene, self.view, self.action = settings, scene, view, action
        self.seeds = world_seeds(settings.seed, settings.scenarios)
        self.worlds = scene.worlds(self.seeds)
        self.steps = max(1, round(settings.horizon_s / scene.dt_s))
        self.size = (view.state.size + 1 + action.size) * settings.hidden + action.size
        seen: list[Array] = []

        def look(_: NDArray[np.int64], snapshot: Snapshot, __: Array) -> None:
            seen.append(view.perceive(snapshot).states)

        roll_out(
            scene,
            StraightPilot(),
            self.seeds,
            start=self.worlds,
            max_steps=self.steps,
            watcher=look,
        )
        states = np.concatenate(seen)
        self.offset, spread = states.mean(axis=0), states.std(axis=0)
        self.scale = np.where(spread > 1e-6, spread, 1.0)

    def parts(self, weights: Array) -> tuple[Array, Array, Array, Array]:
        """Of networks `weights` (networks, size): inner, inner bias, outer, outer bias."""
        states, hidden, actions = self.view.state.size, self.settings.hidden, self.action.size
        ends = np.cumsum([states * hidden, hidden, hidden * actions])
        inner, inner_bias, outer, outer_bias = np.split(weights, ends, axis=1)
        half = (self.action.high - self.action.low) / 2
        middle = (self.action.high + self.action.low) / 2
        return (
            inner.reshape(-1, states, hidden),
            inner_bias,
            outer.reshape(-1, hidden, actions) * half,
            outer_bias * half + middle,
        )

    def network(self, weights: Array) -> MLPPolicy:
        """One of them as a learner that was fitted to nothing."""
        made = MLPPolicy(hidden=self.settings.hidden, seed=self.settings.seed)
        inner, inner_bias, outer, outer_bias = (part[0] for part in self.parts(weights[None]))
        made.inner_, made.inner_bias_ = inner, inner_bias
        made.outer_, made.outer_bias_ = outer, outer_bias
        made.offset_, made.scale_ = self.offset, self.scale
        made.n_features_in_, made.flat_ = self.view.state.size, False
        return made.prepare()

    def scores(self, weights: Array, n_jobs: int) -> tuple[Array, int]:
        """How good each of `weights` (networks, size) is, and how many decisions that took."""
        each = max(1, CHUNK // len(self.seeds))
        if n_jobs != 1:
            each = min(each, FEW)
        parts = [weights[start : start + each] for start in range(0, len(weights), each)]
        done = joblib.Parallel(n_jobs)(joblib.delayed(self._fly)(part) for part in parts)
        return np.concatenate([scores for scores, _ in done]), sum(steps for _, steps in done)

    def _fly(self, weights: Array) -> tuple[Array, int]:
        count = len(self.seeds)
        start = self.worlds.take(np.tile(np.arange(count), len(weights)))
        came = np.zeros(start.worlds)

        def follow(alive: NDArray[np.int64], snapshot: Snapshot, _: Array) -> None:
            came[alive] = self.scene.progress(snapshot)

        flown = roll_out(
            self.scene,
            _Networks(self.view, self.offset, self.scale, self.parts(weights), count),
            self.seeds * len(weights),
            start=start,
            max_steps=self.steps,
            watcher=follow,
        )
        fine = [0, *(self.scene.outcomes.index(name) for name in self.scene.successes)]
        lost = ~np.isin(flown.outcomes, fine)
        score = came - self.settings.loss * lost - self.settings.calm * flown.turn
        return score.reshape(len(weights), count).mean(axis=1), int(flown.steps.sum())


@dataclass(frozen=True)
class _Networks(Pilot):
    """Many networks at once: the first flies the first `each` worlds, and so on."""

    view: Perception
    offset: Array
    scale: Array
    parts: tuple[Array, Array, Array, Array]
    each: int
    name: str = "networks"

    def begin(self, scene: Scene, seeds: Sequence[int]) -> Memory:
        return {"network": np.arange(len(seeds)) // self.each}

    def act(self, scene: Scene, snapshot: Snapshot, memory: Memory) -> tuple[Array, Memory]:
        inner, inner_bias, outer, outer_bias = self.parts
        own = memory["network"]
        percept = self.view.perceive(snapshot)
        states = (percept.states - self.offset) / self.scale
        units = inner_bias[own]
        for component in range(states.shape[1]):
            units = units + states[:, component, None] * inner[own, component]
        units = np.tanh(units)
        actions = (units[:, :, None] * outer[own]).sum(axis=1) + outer_bias[own]
        return self.view.to_world(percept.frame, actions), memory


class _Optimiser(Protocol):
    def __init__(self, settings: Pegasus, size: int) -> None: ...

    def ask(self) -> Array:
        """What to try, (population, size)."""

    def tell(self, tried: Array, scores: Array) -> None:
        """How good each of them was, (population,); higher is better."""


@dataclass
class _Climb:
    """Hill climbing: changes by chance, kept where they are better; smaller when none is."""

    settings: Pegasus
    size: int
    top: float = -np.inf
    here: Array = field(init=False)

    def __post_init__(self) -> None:
        self.rng = np.random.default_rng(self.settings.seed)
        self.here, self.step = np.zeros(self.size), self.settings.spread

    def ask(self) -> Array:
        changes = self.rng.normal(size=(self.settings.population, self.size))
        return np.asarray(np.clip(self.here + self.step * changes, -LARGEST, LARGEST))

    def tell(self, tried: Array, scores: Array) -> None:
        if scores.max() > self.top:
            self.here, self.top = tried[scores.argmax()], float(scores.max())
            self.step *= 1.1
        else:
            self.step *= 0.85


class _Evolution:
    """CMA-ES: Hansen, "The CMA evolution strategy: a tutorial", 2016, by the package `cmaes`."""

    def __init__(self, settings: Pegasus, size: int) -> None:
        try:
            from cmaes import CMA
        except ImportError:
            raise ConflictError(
                "CMA-ES needs the package `cmaes`, which is not installed. Install "
                "evastudio[pegasus], or search by hill-climbing."
            ) from None
        bounds = np.tile((-LARGEST, LARGEST), (size, 1))
        self._inner: Any = CMA(
            mean=np.zeros(size),
            sigma=settings.spread,
            bounds=bounds,
            seed=settings.seed % 2**32,
            population_size=settings.population,
        )
        self._population = settings.population

    def ask(self) -> Array:
        return np.array([self._inner.ask() for _ in range(self._population)])

    def tell(self, tried: Array, scores: Array) -> None:
        self._inner.tell([(one, -score) for one, score in zip(tried, scores, strict=True)])
