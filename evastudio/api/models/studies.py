"""Studies of people over HTTP, field by field."""

from __future__ import annotations

from typing import Annotated

from pydantic import ConfigDict, Field

from evastudio.api.models.common import Given, Model, Name


class StudyIn(Given):
    """Of somebody who agreed that it is kept."""

    model_config = ConfigDict(
        json_schema_extra={
            "examples": [{"session": 1, "person": "artist", "instructed_s": 95.0}],
        }
    )

    session: Annotated[int, Field(ge=1, lt=2**31)]
    """What they demonstrated: how long that took is read from its kept takes."""
    person: Name
    """What they do; no name."""
    instructed_s: Annotated[float, Field(ge=0.0, lt=1e6)] | None = None
    preferred: Name | None = None


class StudyOut(Model):
    id: int
    created_at: float
    scene: str
    person: str
    instructed_s: float | None
    demonstrated_s: float
    preferred: str | None
