"""Reasons over HTTP, field by field."""

from __future__ import annotations

from evastudio.api.models.asking import SourceOut
from evastudio.api.models.common import Model


class MomentOut(SourceOut):
    action: dict[str, float] | None
    """What was done then, as it would be done here."""


class WhyOut(Model):
    policy: str
    familiarity: float | None
    """How much the moment is like what was demonstrated, 0 to 1."""
    agreement: float | None
    """1 where the moments' actions are the same, 0 where they differ as any two would."""
    moments: list[MomentOut]
    """The demonstrated moments that it decided by, the nearest first."""
