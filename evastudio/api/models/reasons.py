"""Reasons over HTTP, field by field."""

from __future__ import annotations

from pydantic import BaseModel


class MomentOut(BaseModel):
    take: int | None
    """None where the policy does not know what it learned from."""
    step: int | None
    distance: float
    """How far its state is from the present one, standardised."""
    weight: float
    """How much it counted; those of all moments add up to 1."""
    action: dict[str, float] | None
    """What was done then, as it would be done here."""


class WhyOut(BaseModel):
    policy: str
    familiarity: float | None
    """How much the moment is like what was demonstrated, 0 to 1."""
    agreement: float | None
    """1 where the moments' actions are the same, 0 where they differ as any two would."""
    moments: list[MomentOut]
    """The demonstrated moments that it decided by, the nearest first."""
