"""Evaluations over HTTP, field by field."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any

from pydantic import Field

from evastudio.api.models.common import Model, Name, Options, Seed


class EvaluateIn(Model):
    scene: Name
    policies: Annotated[list[Name], Field(min_length=1, max_length=20)]
    """Policies, scripted demonstrators or other pilots, by name."""
    options: Options
    worlds: Annotated[int, Field(ge=1, le=100_000)] = 100
    seed: Seed = 0
    like: Name | None = None
    """The one of them that the others should move like."""


class EvaluationOut(Model):
    id: int
    scene: str
    created_at: float
    asked: Mapping[str, Any]
    """What makes it again."""
    versions: Mapping[str, str]
    result: Mapping[str, Any]
