"""The report of a tuning: what was measured, and what it says in plain sentences."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any

from evastudio.learning.candidates import Candidate
from evastudio.learning.trials import Trial

NAMES: Mapping[str, str] = {
    "svr": "Smooth",
    "knn": "Exact",
    "local-linear": "Local lines",
    "voting": "Majority",
}
"""By learner, as the page says them: without the names of methods."""
FEW = 4
"""Takes below which a report says that they are few."""


@dataclass(frozen=True)
class Row:
    """What one candidate gave."""

    candidate: Candidate
    error: float
    """On held-out takes, see `Tuning.error`; the lowest of many is lower than it deserves."""
    typical: float
    """See `Tuning.typical`."""

    @staticmethod
    def of(trial: Trial) -> Row:
        return Row(trial.candidate, trial.held_out.error, trial.typical)


@dataclass(frozen=True)
class Tuning:
    """What tuning chose and why. Errors are on held-out takes: for numbers the root mean square
    in units of each component's spread, so that 1 is about a constant; for symbols the share of
    wrong ones."""

    pairs: int
    takes: int
    symbols: bool
    """Whether actions are symbols."""
    chosen: Candidate
    error: float
    """Of tuning as a whole: each take is judged by the settings that the other takes would have
    chosen. Those were compared by errors on takes that learned from this one, which no nesting
    short of fitting everything anew would avoid."""
    typical: float
    """Mean size of a mistake, in the same unit: a demonstrator's slips hardly move it."""
    constant: float
    """Error of always doing the same."""
    linear: float
    """Error of a linear map (ridge regression)."""
    beats_constant: bool
    beats_linear: bool
    by_take: Mapping[int, Mapping[str, float]]
    """For each take the errors of what was chosen, of the constant and of the linear map."""
    trials: tuple[Row, ...]
    """Everything tried on all takes."""
    roughness: float | None
    """Best error of a smooth surface (SVR) over that of the most similar moments (k-NN): above 1
    where moves change abruptly. None where not both were tried."""
    recommended: str | None
    """As the paper does: svr for smooth mappings, knn for rough ones (section 3.2); None where
    the takes do not tell."""
    cleaning: tuple[float, float] | None
    """Error of the chosen settings without cleaning and with it; None where it was not tried."""
    cleaning_helps: bool
    cleaning_harms: bool
    learning: tuple[tuple[float, float], ...]
    """Shares of the takes learned from, and errors; only of all where half is too few."""
    more_would_help: bool
    """Whether all takes gave a lower error than half of them."""
    perceptions: Mapping[str, float]
    """Errors in the world's frame under each perception, with the chosen settings; the first is
    the one tuned for. Empty where there is but one."""
    better_perception: str | None
    """The perception under which the error is lower, although the settings were chosen for
    another; None where there is none."""

    @property
    def sentences(self) -> tuple[str, ...]:
        """What an animator should know, the most important first."""
        said = [self._result(), self._mapping(), self._more()]
        if self.better_perception is not None:
            said.append(
                f"The perception '{self.better_perception}' tells more: with it, unseen moves were "
                f"{_percent(self._own_perception, self.perceptions[self.better_perception])} "
                "closer. Try it."
            )
        said.append(self._cleaning())
        if self.takes >= FEW and not (self.symbols or self.beats_constant):
            said.append("What decides you may not be in what the character sees.")
        if self.takes < FEW:
            said.append(f"There are only {self.takes} takes, from which little can be told.")
        said.append("This was measured move by move: play it to see how it does on its own.")
        return tuple(sentence for sentence in said if sentence)

    @property
    def _own_perception(self) -> float:
        return next(iter(self.perceptions.values()))

    def _result(self) -> str:
        name = NAMES.get(self.chosen.learner, self.chosen.learner)
        start = f"{name} was chosen."
        if self.symbols:
            right, usual = 100.0 * (1.0 - self.error), 100.0 * (1.0 - self.constant)
            return (
                f"{start} On takes it had not seen it chose as you did in {right:.0f} % of the "
                f"moments; always the same choice gives {usual:.0f} %."
            )
        if not self.beats_constant:
            return (
                f"{start} On takes it had not seen it was not reliably closer to your moves than "
                "one unchanging move."
            )
        linear = (
            f" and {_percent(self.linear, self.error)} closer than a straight-line rule."
            if self.beats_linear
            else ", but not reliably closer than a straight-line rule."
        )
        return (
            f"{start} On takes it had not seen it was {_percent(self.constant, self.error)} "
            f"closer to your moves than one unchanging move{linear}"
        )

    def _mapping(self) -> str:
        if self.roughness is None:
            return ""
        if self.recommended == "svr":
            return "You change your moves smoothly with what the character sees: Smooth suits that."
        if self.recommended == "knn":
            return "You change your moves abruptly with what the character sees: Exact suits that."
        return "Smooth and Exact came out alike on these takes."

    def _more(self) -> str:
        if len(self.learning) < 2:
            return ""
        (_, half), (_, whole) = self.learning[0], self.learning[-1]
        if self.more_would_help:
            return (
                f"More takes are likely to help: all of them came {_percent(half, whole)} closer "
                "than half of them."
            )
        return "All takes came no closer than half of them: more of the same may change little."

    def _cleaning(self) -> str:
        if self.cleaning is None:
            return ""
        without, cleaned = self.cleaning
        if self.cleaning_helps:
            return f"Taking out contradicting moves helped: {_percent(without, cleaned)} closer."
        if self.cleaning_harms:
            loss = _percent(cleaned, without)
            return f"Taking out contradicting moves did harm: {loss} closer without."
        return "Taking out contradicting moves made no difference that these takes can show."

    def to_json(self) -> dict[str, Any]:
        """Everything, as JSON holds it, errors to six digits."""
        whole: dict[str, Any] = _rounded(self._json())
        return whole

    def _json(self) -> dict[str, Any]:
        return {
            **asdict(self),
            "by_take": {str(take): dict(errors) for take, errors in self.by_take.items()},
            "trials": [
                {**row.candidate.to_json(), "error": row.error, "typical": row.typical}
                for row in self.trials
            ],
            "chosen": self.chosen.to_json(),
            "sentences": list(self.sentences),
        }


def _percent(before: float, after: float) -> str:
    """By how much an error fell, as a person reads it."""
    share = 100.0 * (1.0 - after / before) if before > 0.0 else 0.0
    return "less than 1 %" if share < 1.0 else f"{share:.0f} %"


def _rounded(value: Any) -> Any:
    if isinstance(value, float):
        return float(f"{value:.6g}")
    if isinstance(value, Mapping):
        return {key: _rounded(part) for key, part in value.items()}
    return [_rounded(part) for part in value] if isinstance(value, list | tuple) else value
