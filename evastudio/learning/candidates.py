"""Candidates: which settings tuning tries, learner by learner."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from evastudio.learning.policy import LEARNERS
from evastudio.world.spaces import Space

GRIDS: Mapping[str, Mapping[str, tuple[Any, ...]]] = {
    "svr": {
        "gamma": (0.003, 0.01, 0.03, 0.1, 0.3, 1.0),
        "C": (3.0, 10.0, 30.0, 100.0),
        "epsilon": (0.05, 0.1, 0.2, 0.4),
    },
    "knn": {"k": (1, 3, 5, 9, 15), "weights": ("uniform", "distance")},
    "local-linear": {"k": (20, 40, 80), "ridge": (0.03, 0.1, 0.3, 1.0)},
    "voting": {"k": (1, 3, 5, 9, 15), "weights": ("uniform", "distance")},
}
"""Values in order for each setting that is tuned; learners earlier in the list win ties.

Kernels far broader than scikit-learn's are among them, because reactions in a good frame are
nearly linear. The grids end where hold-out goes on to praise what averages more and more, while
policies cross fewer fields: gamma 0.001 crossed 99.0 and 99.3 % where 0.01 crossed 99.7 % (1,000
fields, scripted human-like demonstrations), and k above 15 blunts sharp turns. A learner that
decides by chance is not here: it is meant to be as varied as the demonstrator, and an error on
single decisions would always choose the least varied.
"""
THRESHOLDS: tuple[float | str, ...] = ("auto", 0.4)
"""Of cleaning, beside none."""


@dataclass(frozen=True)
class Candidate:
    """One way to learn."""

    learner: str
    settings: Mapping[str, Any] = field(default_factory=dict)
    """Those that are not the learner's defaults."""
    threshold: float | str | None = None
    """Of cleaning before learning; None for none."""

    def make(self) -> Any:
        """The learner, not fitted."""
        learner: Any = LEARNERS[self.learner]()
        return learner.set_params(**self.settings)

    def value(self, setting: str) -> Any:
        """What that setting is, whether given or a default."""
        return self.make().get_params()[setting]

    @property
    def neighbors(self) -> int:
        """How many pairs a decision is made from; 1 where the learner has no such number."""
        return int(self.make().get_params().get("k", 1))

    def changed(self, setting: str, value: Any) -> Candidate:
        """With another value of one setting."""
        settings = {**self.settings, setting: value}
        usual = Candidate(self.learner).make().get_params()
        kept = {name: one for name, one in settings.items() if one != usual[name]}
        return Candidate(self.learner, kept, self.threshold)

    def __str__(self) -> str:
        settings = ", ".join(
            f"{name} {value:g}" if isinstance(value, float) else f"{name} {value}"
            for name, value in self.settings.items()
        )
        cleaned = "" if self.threshold is None else f", cleaned at {self.threshold}"
        return f"{self.learner} ({settings or 'defaults'}{cleaned})"

    def to_json(self) -> dict[str, Any]:
        return {
            "learner": self.learner,
            "settings": dict(self.settings),
            "threshold": self.threshold,
        }


def tuned_learners(action: Space) -> tuple[str, ...]:
    """Names of the learners that can be tuned for an `action` of this kind, the preferred first."""
    return tuple(name for name in GRIDS if isinstance(action, LEARNERS[name].acts_in))


def others(candidate: Candidate, setting: str) -> list[Candidate]:
    """`candidate` with each other value of one setting, in order."""
    grid = GRIDS[candidate.learner][setting]
    return [
        candidate.changed(setting, value) for value in grid if value != candidate.value(setting)
    ]
