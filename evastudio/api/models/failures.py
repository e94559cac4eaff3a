"""Failures of policies over HTTP, field by field."""

from __future__ import annotations

from typing import Annotated

from pydantic import ConfigDict, Field

from evastudio.api.models.common import Given, Name, Options, Seed


class FailuresIn(Given):
    model_config = ConfigDict(
        json_schema_extra={"examples": [{"policy": "asteroids-careful", "worlds": 32, "seed": 1}]}
    )

    policy: Name
    """A policy, or another pilot."""
    scene: Name | None = None
    """The policy's own where none is named."""
    options: Options
    worlds: Annotated[int, Field(ge=1, le=10_000)] = 64
    """At most so many are flown."""
    seed: Seed = 0
    most: Annotated[int, Field(ge=1, le=100)] = 8
    """Failures that are enough."""
