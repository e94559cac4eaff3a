"""Questions to a policy over HTTP, field by field."""

from __future__ import annotations

from typing import Annotated, Self

from pydantic import Field, model_validator

from evastudio.api.models.common import Given, Model, Seed, at_most
from evastudio.api.models.takes import Row, Step

MOST_ASKED = 20_000
"""States that can be asked about at once as JSON."""
MOST_EXPLAINED = 2000

States = Annotated[list[Row], Field(min_length=1), at_most(MOST_ASKED)]


class MomentsIn(Given):
    """Moments of a take to decide in, whatever the policy perceives of them."""

    take: Annotated[int, Field(ge=1, lt=2**31)]
    steps: Annotated[list[Step], Field(min_length=1), at_most(MOST_ASKED)]


class DecideIn(Given):
    """Either states, or moments of a take."""

    states: States | None = None
    seed: Seed | None = None
    """Of the luck of a policy that draws; without one it gives what was shown most often."""
    moments: MomentsIn | None = None

    @model_validator(mode="after")
    def _one_of_both(self) -> Self:
        if (self.states is None) == (self.moments is None):
            raise ValueError("give either states or moments of a take")
        return self


class DecisionsOut(Model):
    actions: list[list[float]]
    """One row for each state, in the character's own frame; for moments, in the world's."""
    fields: list[str]
    """What the numbers of a row are."""
    symbols: list[str] | None
    """The symbols that the actions are; None where they are numbers."""


class ExplainIn(Given):
    states: Annotated[list[Row], Field(min_length=1), at_most(MOST_EXPLAINED)]


class SourceOut(Model):
    take: int | None
    """The take in which it was shown; None where the policy's file does not tell."""
    step: int | None
    distance: float
    """How far the state shown there is from the one asked about, standardised."""
    weight: float
    """How much it counted; those of one state sum to 1."""


class ExplanationOut(Model):
    neighbors: list[SourceOut]
    """Nearest first."""
    nearest: float
    """The distance to the nearest demonstration, standardised: far is far from what was shown."""
    agreement: float | None
    """1 where the neighbours agree, 0 where they differ as all pairs do."""


class ExplanationsOut(Model):
    session: int | str | None
    """Whose takes these are."""
    explanations: list[ExplanationOut]
    """One for each state."""
