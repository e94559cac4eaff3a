"""Conflicts and what people say of them over HTTP, field by field."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Literal

from fastapi import Query
from pydantic import ConfigDict, Field

from evastudio.api.models.common import Given, Model
from evastudio.demonstrations.records import Verdict

Threshold = Annotated[
    Annotated[float, Field(gt=0.0, le=10.0)] | Literal["auto"],
    Query(description="How far off a conflict is, as a share of the range; or by itself."),
]


class ConflictOut(Model):
    take: int
    number: int
    """Of the take in its session, from 1."""
    step: int
    seconds: float
    """When in its take, of the moment that the action answered."""
    says: str
    """What is odd about it, for its demonstrator."""
    action: Mapping[str, float]
    """In the character's own frame; a symbol as {its name: 1}."""
    usual: Mapping[str, float]
    """The median of what was done in moments like it."""
    deviation: float
    """How far it is off, as a share of the range."""
    limit: float
    conflict: bool
    """Whether it is farther off than the limit."""
    verdict: Verdict | None
    goes: bool
    """Whether cleaning would leave it out."""


class ConflictsOut(Model):
    pairs: int
    """That were looked at and are kept still."""
    conflicts: int
    goes: int
    """Pairs that cleaning would leave out, what was said of single ones included."""
    limit: float
    """The middle of the limits."""
    perception: str
    neighbors: int
    symbols: bool
    stale: bool
    """Takes were added, thrown away or brought back since: look again."""
    items: tuple[ConflictOut, ...]
    """Conflicts, and pairs that something was said of, the farthest off first."""


class NeighborOut(Model):
    take: int
    step: int
    action: Mapping[str, float]
    """In the character's own frame."""


class ComparedOut(Model):
    conflict: ConflictOut
    neighbors: list[NeighborOut]
    """What it was compared with, the nearest first."""


class VerdictIn(Given):
    model_config = ConfigDict(json_schema_extra={"examples": [{"verdict": "keep"}]})

    verdict: Annotated[Verdict, Field(strict=False)]
    """keep: it was meant; delete: it was a mistake; missing: it was meant, and the perception does
    not show what tells it from the others. Cleanings to come heed it."""


class VerdictOut(Model):
    take: int
    step: int
    verdict: Verdict


class VerdictsOut(Model):
    items: list[VerdictOut]
    """In the order of takes and steps."""
