"""Sessions and the work on them over HTTP, field by field."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, Literal

from pydantic import ConfigDict, Field

from evastudio.api.models.common import Delay, Given, Model, Name, Options, PolicyName, Seed


class SessionIn(Given):
    model_config = ConfigDict(
        json_schema_extra={"examples": [{"scene": "asteroids", "name": "Wide turns"}]}
    )

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


class CleanIn(Given):
    model_config = ConfigDict(json_schema_extra={"examples": [{"threshold": "auto"}]})

    perception: Name | None = None
    n_neighbors: Annotated[int, Field(ge=1, le=1000)] | None = None
    threshold: Annotated[float, Field(gt=0.0, le=10.0)] | Literal["auto"] | None = None
    delay: Delay = "auto"


class PreviewIn(CleanIn):
    worst: Annotated[int, Field(ge=0, le=1000)] = 20
    """So many of the conflicts are told with what they were compared with."""


class RecordIn(Given):
    model_config = ConfigDict(
        json_schema_extra={
            "examples": [{"scene": "asteroids", "minutes": 0.1, "session": "By script"}]
        }
    )

    scene: Name
    pilot: Name = "scripted:careful"
    """A scripted demonstrator."""
    minutes: Annotated[float, Field(gt=0.0, le=600.0)] = 8.0
    seed: Seed = 0
    """Decides every world."""
    options: Options
    session: Name | None = None
    """Name of the new session."""
    mark: Annotated[str, Field(min_length=1, max_length=400)] | None = None
    """Moments are marked when this condition begins or ceases to hold."""


class ImportIn(Given):
    model_config = ConfigDict(
        json_schema_extra={"examples": [{"files": ["corridor.txt"], "people": 20}]}
    )

    files: Annotated[list[Name], Field(min_length=1, max_length=100)]
    """Recordings of the workspace, by name."""
    scene: Name = "street"
    session: Name | None = None
    people: Annotated[int, Field(ge=1, le=10_000)] = 60
    """Takes from each file, one a person."""
    fps: Annotated[float, Field(ge=0.5, le=1000.0)] | None = None
    """Frames a second, where the file does not say."""
    credit: Name | None = None


class TuneIn(Given):
    model_config = ConfigDict(json_schema_extra={"examples": [{"learner": "svr"}]})

    learner: Name | None = None
    perception: Name | None = None


class DiagnoseIn(Given):
    model_config = ConfigDict(json_schema_extra={"examples": [{"delay": "off"}]})

    perception: Name | None = None
    delay: Delay = "auto"


class FitIn(Given):
    model_config = ConfigDict(
        json_schema_extra={
            "examples": [{"learner": "knn", "settings": {"k": 5}, "name": "wide-turns"}]
        }
    )

    learner: Name | None = None
    perception: Name | None = None
    settings: Annotated[dict[Name, Any], Field(default_factory=dict, max_length=100)]
    delay: Delay = "auto"
    name: PolicyName | None = None


class PlacesIn(Given):
    places: Annotated[int, Field(ge=1, le=100)] = 8
    seed: Seed = 0
