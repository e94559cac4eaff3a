"""What people say of conflicts over HTTP, field by field. Conflicts are told as `live.weighing` has
them."""

from __future__ import annotations

from typing import Annotated, Literal

from fastapi import Query
from pydantic import ConfigDict, Field

from evastudio.api.models.common import Given, Model
from evastudio.demonstrations.records import Verdict

Threshold = Annotated[
    Annotated[float, Field(gt=0.0, le=10.0)] | Literal["auto"],
    Query(description="How far off a conflict is, as a share of the range; or by itself."),
]


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
