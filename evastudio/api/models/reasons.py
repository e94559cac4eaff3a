"""Reasons over HTTP, field by field."""

from __future__ import annotations

from evastudio.api.models.asking import SourceOut
from evastudio.api.models.common import Model


class MomentOut(SourceOut):
    number: int | None
    """Of the take in its session; None where the take is not there any more."""
    session: str | None
    """Name of the session of the take."""
    seconds: float | None
    """When in its take the moment was."""
    action: dict[str, float] | None
    """What was done then, as it would be done here."""


class WhyOut(Model):
    policy: str
    silent: str | None
    """Why there are no moments to show; null where there are."""
    familiarity: float | None
    """How much the moment is like what was demonstrated, 0 to 1."""
    agreement: float | None
    """1 where the moments' actions are the same, 0 where they differ as any two would."""
    moments: list[MomentOut]
    """The demonstrated moments that it decided by, the nearest first."""
