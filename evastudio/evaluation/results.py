"""What an evaluation found, world by world, and what follows from it."""

from __future__ import annotations

import itertools
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from evastudio.evaluation.interval import Interval, mean_interval, wilson_interval
from evastudio.evaluation.pairing import Difference, compare_figures, compare_rates, holm
from evastudio.world.snapshot import AnyArray
from evastudio.world.spaces import Array

SUCCESS = "success_rate"


@dataclass(frozen=True)
class Evaluation:
    """How one pilot fared, in the order of the worlds."""

    pilot: str
    endings: tuple[str, ...]
    """The scene's outcomes; the first where a world did not end in time."""
    outcomes: NDArray[np.int64]
    """Which of `endings` each world came to, shape (worlds,)."""
    succeeded: NDArray[np.bool_]
    """Worlds that ended with one of the scene's successes, shape (worlds,)."""
    figures: Mapping[str, Array]
    """By name, shape (worlds,); NaN where a world has none. See `docs/evaluation.md`."""
    unlike: float | None = None
    """How far its way of moving is from the pilot it should be like, 0 to 1; for that pilot
    itself, what chance alone gives. None where there is no such pilot."""
    decision_us: float | None = None
    """Median time of one decision for one world; it depends on the machine and its load."""

    @property
    def worlds(self) -> int:
        return len(self.outcomes)

    @property
    def success_rate(self) -> float:
        return float(self.succeeded.mean())

    @property
    def interval(self) -> Interval:
        """Wilson 95 % interval of the success rate."""
        return wilson_interval(int(self.succeeded.sum()), self.worlds)

    @property
    def counts(self) -> dict[str, int]:
        """How many worlds ended in each way."""
        return {
            name: int((self.outcomes == index).sum()) for index, name in enumerate(self.endings)
        }

    def mean(self, figure: str) -> float | None:
        """Over the worlds that have it; None where none has."""
        finite = self._finite(figure)
        return float(finite.mean()) if len(finite) else None

    def to_json(self) -> dict[str, Any]:
        """The figures, as JSON holds them."""
        return {
            "worlds": self.worlds,
            "succeeded": int(self.succeeded.sum()),
            SUCCESS: self.success_rate,
            "interval": list(self.interval),
            "outcomes": self.counts,
            "figures": {name: self._summary(name) for name in self.figures},
            "unlike": self.unlike,
            "decision_us": self.decision_us,
        }

    def _finite(self, figure: str) -> Array:
        values = self.figures[figure]
        return np.asarray(values[np.isfinite(values)])

    def _summary(self, figure: str) -> dict[str, Any] | None:
        finite = self._finite(figure)
        if len(finite) == 0:
            return None
        low, high = mean_interval(finite)
        return {
            "mean": float(finite.mean()),
            "interval": [low, high],
            "median": float(np.median(finite)),
            "worlds": len(finite),
        }


@dataclass(frozen=True)
class Comparison:
    """Several pilots on the same worlds."""

    scene: Mapping[str, Any]
    """Identity of the scene: name, version, options."""
    seed: int
    worlds: int
    pilots: Mapping[str, Evaluation]
    like: str | None = None
    """The pilot that the others should move like, or whose takes."""
    chance: float | None = None
    """How unlike one half of what that one did is to the other half."""

    def differences(self, ours: str, theirs: str) -> dict[str, Difference]:
        """The pilot `ours` less `theirs`, world by world, in each figure that both have."""
        first, second = self.pilots[ours], self.pilots[theirs]
        found = {SUCCESS: compare_rates(first.succeeded, second.succeeded)}
        for name in first.figures:
            if name in second.figures:
                difference = compare_figures(first.figures[name], second.figures[name])
                if difference is not None:
                    found[name] = difference
        return found

    def disputed(self) -> list[int]:
        """The worlds that ended well for some and not for others, from 0."""
        well = np.stack([one.succeeded for one in self.pilots.values()])
        return [int(world) for world in np.flatnonzero(well.any(axis=0) & ~well.all(axis=0))]

    def to_arrays(self) -> dict[str, AnyArray]:
        """What `from_arrays` makes it of again, beside its JSON."""
        arrays: dict[str, AnyArray] = {}
        for number, one in enumerate(self.pilots.values()):
            arrays |= {f"{number}.outcomes": one.outcomes, f"{number}.succeeded": one.succeeded}
            arrays |= {f"{number}.figures.{name}": each for name, each in one.figures.items()}
        return arrays

    @classmethod
    def from_arrays(cls, told: Mapping[str, Any], arrays: Mapping[str, AnyArray]) -> Self:
        """The comparison whose JSON is `told` and whose worlds are in `arrays`."""
        pilots = {}
        for number, (name, one) in enumerate(told["pilots"].items()):
            pilots[name] = Evaluation(
                pilot=name,
                endings=tuple(one["outcomes"]),
                outcomes=arrays[f"{number}.outcomes"],
                succeeded=arrays[f"{number}.succeeded"],
                figures={each: arrays[f"{number}.figures.{each}"] for each in one["figures"]},
                unlike=one["unlike"],
                decision_us=one["decision_us"],
            )
        like, chance = told["like"], told.get("chance")
        return cls(told["scene"], told["seed"], told["worlds"], pilots, like, chance)

    def to_json(self) -> dict[str, Any]:
        """The figures, as JSON holds them; all but `decision_us` repeat exactly.

        `p_corrected` of a difference is Holm's, for all that are compared here at once.
        """
        pairs = list(itertools.combinations(self.pilots, 2))
        found = [self.differences(*pair) for pair in pairs]
        corrected = iter(holm([one.p for by in found for one in by.values()]))
        return {
            "scene": dict(self.scene),
            "seed": self.seed,
            "worlds": self.worlds,
            "like": self.like,
            "chance": self.chance,
            "pilots": {name: one.to_json() for name, one in self.pilots.items()},
            "differences": [
                {
                    "pilots": list(pair),
                    **{
                        name: {**one.to_json(), "p_corrected": next(corrected)}
                        for name, one in by.items()
                    },
                }
                for pair, by in zip(pairs, found, strict=True)
            ],
        }
