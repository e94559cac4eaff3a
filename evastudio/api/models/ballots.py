"""Ballots over HTTP, field by field. Nothing here names a pilot before somebody has voted."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field

from evastudio.api.models.common import Given, Model, Name, Options, Seed


class BallotIn(Given):
    model_config = ConfigDict(
        json_schema_extra={
            "examples": [
                {"scene": "asteroids", "pilots": ["asteroids-careful", "scripted:careful"]}
            ]
        }
    )

    scene: Name
    pilots: Annotated[list[Name], Field(min_length=2, max_length=2)]
    options: Options
    seed: Seed = 0
    """Of the worlds that they are shown in, one for each vote of a person."""


class BallotOut(BaseModel):
    id: int
    scene: str
    title: str
    """Of the scene; its name where it is not there any more."""
    created_at: float
    votes: int
    """Of everybody, those who saw no difference too."""
    mine: int
    """One's own."""


class VoteIn(Given):
    lineup: Name
    """The one that was looked at."""
    livelier: Literal["left", "right", "neither"]


class PreferenceOut(Model):
    ballot: int
    scene: str
    pilots: Sequence[str]
    votes: Sequence[int]
    """For each of them."""
    neither: int
    people: int
    """Who voted, by their tokens."""
    share: float | None
    """Of the votes for one of them, those for the one that has more."""
    interval: Sequence[float] | None
    """95 %, of `share` (Wilson)."""
    says: str


class VoteOut(BaseModel):
    left: str
    right: str
    livelier: str | None
    """Who that was; None for no difference."""
    preference: PreferenceOut
    """What has come of the ballot with this vote."""
