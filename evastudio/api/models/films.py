"""Films over HTTP, field by field."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import ConfigDict, Field

from evastudio.api.models.common import Given, Model, Name

Side = Annotated[int, Field(ge=64, le=3840, multiple_of=2)]


class FilmIn(Given):
    model_config = ConfigDict(json_schema_extra={"examples": [{"form": "html"}]})

    form: Literal["html", "mp4"] = "html"
    """A page that plays in 3D with no network, or a video."""
    width: Side = 1280
    height: Side = 720
    """Of a video."""


class TakeFilmIn(FilmIn):
    camera: Name | None = None
    """From where it is seen; the scene's first camera where it is None."""


class FilmOut(Model):
    name: str
    bytes: int
    created_at: float
