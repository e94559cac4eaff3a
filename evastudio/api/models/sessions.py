"""Sessions and the work on them over HTTP, field by field."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, Literal

from pydantic import Field

from evastudio.api.models.common import Delay, Model, Name


class SessionIn(Model):
    scene: Name
    name: Name
    demonstrator: Name = "person"


class CleaningOut(Model):
    pairs: int
    removed: int
    stale: bool
    created_at: float
    settings: Mapping[str, Any]


class SessionOut(Model):
    id: int
    name: str
    scene: str
    scene_version: int
    demonstrator: str
    created_at: float
    made_by: str
    takes_kept: int
    takes_trashed: int
    pairs: int
    seconds: float
    cleaning: CleaningOut | None


class CleanIn(Model):
    perception: Name | None = None
    n_neighbors: Annotated[int, Field(ge=1, le=1000)] | None = None
    threshold: Annotated[float, Field(gt=0.0, le=10.0)] | Literal["auto"] | None = None
    delay: Delay = "auto"


class TuneIn(Model):
    learner: Name | None = None
    perception: Name | None = None


class DiagnoseIn(Model):
    perception: Name | None = None
    delay: Delay = "auto"


class FitIn(Model):
    learner: Name | None = None
    perception: Name | None = None
    settings: Annotated[dict[Name, Any], Field(default_factory=dict, max_length=100)]
    delay: Delay = "auto"
    name: Annotated[str, Field(max_length=80)] | None = None
