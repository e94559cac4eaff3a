"""Policies and switches over HTTP, field by field."""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import BaseModel, ConfigDict, Field

from evastudio.api.models.common import Given, Name, PolicyName


class EntryIn(Given):
    policy: Name
    when: Annotated[str, Field(min_length=1, max_length=400)] | None = None
    """Text of the condition; none for the last."""


class SwitchIn(Given):
    model_config = ConfigDict(
        json_schema_extra={
            "examples": [
                {
                    "name": "walk-then-flee",
                    "entries": [
                        {"policy": "crowd-fleeing", "when": "event:impact"},
                        {"policy": "crowd-hurried"},
                    ],
                }
            ]
        }
    )

    name: PolicyName
    entries: Annotated[list[EntryIn], Field(min_length=2, max_length=16)]
    perception: Name | None = None
    """What a learned condition may look at beside the signs of the scene."""


class PolicyOut(BaseModel):
    name: str
    scene: str | None
    scene_version: int | None
    perception: str | None
    learner: str | None
    settings: dict[str, Any]
    pairs: int | None
    session: str | None
    """Name of the session it was fitted to."""
    report: list[str]
    """What fitting or tuning said of it, or when a switch switches, for people."""
    in_short: list[str]
    """The same for animators: without fields of the state and their figures."""
    switches: list[str]
    """The policies of a switch, the first choice first; empty for a policy."""
    made_by: str | None
    created: str | None
    shipped: bool
    stale: bool
    """The session's pairs have changed since it was fitted."""
    made_before: str | None
    """What has changed, as "made before 2 takes were added"; None where nothing has."""
    problem: str | None
    """Why it cannot play, or None."""
