"""Recordings of people over HTTP, field by field."""

from __future__ import annotations

from evastudio.api.models.common import Model


class WalkFileOut(Model):
    name: str
    bytes: int
