"""Takes over HTTP, field by field."""

from __future__ import annotations

from collections.abc import Mapping

from evastudio.api.models.common import Model


class TakeOut(Model):
    id: int
    session: int
    number: int
    scene_version: int
    seed: int
    options: Mapping[str, float]
    pilot: str
    pairs: int
    seconds: float
    outcome: str | None
    started_at: float
    trashed: bool
