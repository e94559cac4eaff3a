"""Evaluations over HTTP, field by field."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field

from evastudio.api.models.common import Given, Model, Name, Options, Seed


class EvaluateIn(Given):
    model_config = ConfigDict(
        json_schema_extra={
            "examples": [
                {"scene": "asteroids", "policies": ["asteroids-careful", "straight"], "worlds": 10}
            ]
        }
    )

    scene: Name
    policies: Annotated[list[Name], Field(min_length=1, max_length=20)]
    """Policies, scripted demonstrators or other pilots, by name."""
    options: Options
    worlds: Annotated[int, Field(ge=1, le=100_000)] = 100
    seed: Seed = 0
    like: Name | None = None
    """The one of them that the others should move like."""
    like_session: int | None = None
    """Or the session whose takes they should."""


class EvaluationOut(Model):
    id: int
    scene: str
    created_at: float
    asked: Mapping[str, Any]
    """What makes it again."""
    versions: Mapping[str, str]
    result: Mapping[str, Any]
    says: Sequence[str]
    """Of each pair of pilots what was found, in words."""
    labels: Mapping[str, str]
    """What people call each figure, by its name."""


class DisputedOut(BaseModel):
    worlds: list[int]
    """Those that ended well for some and not for others, from 0; the first of them."""
    count: int
    """How many there are."""


class PictureOut(BaseModel):
    name: str
    title: str
    """What it shows."""
    svg: str
    png: str
    """Paths of the files."""


class PicturesOut(BaseModel):
    items: list[PictureOut]
    left_out: str | None
    """Why something is missing, or None."""
    whole: bool
    """Whether they show what is known now; drawing makes it so."""


class PilotOut(Model):
    name: str
    kind: Literal["own", "shipped", "program"]
    """A policy of the workspace, one that comes along, or a program."""
