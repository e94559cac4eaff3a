"""Looking back over HTTP, field by field."""

from __future__ import annotations

from typing import Literal

from evastudio.api.models.common import Model


class HappeningOut(Model):
    seconds: float
    """Since the run began."""
    kind: Literal["sign", "near", "hand", "outcome"]
    """A sign of the scene, a close call, somebody who took over from what plays or handed back, or
    how the world ended."""
    says: str
    """What it was; of an outcome its name."""


class StripOut(Model):
    first_s: float
    """What was before is forgotten."""
    length_s: float
    familiarity: list[float | None]
    """Of each part of the time from `first_s` to `length_s`, all as long, the least there was, 0
    to 1; null where no policy decided."""
    happenings: list[HappeningOut]
