"""What every room of the API shares."""

from __future__ import annotations

from typing import Annotated, Generic, Literal, TypeVar

from pydantic import BaseModel, ConfigDict, Field, FiniteFloat

T = TypeVar("T")
Delay = Annotated[float, Field(ge=0.0, le=2.0)] | Literal["auto", "off"]
"""Reaction delay to take out: as estimated where that helps, none, or so many seconds."""
Name = Annotated[str, Field(min_length=1, max_length=200)]
Options = Annotated[dict[Name, FiniteFloat], Field(default_factory=dict, max_length=100)]
"""Of a scene, by name; its own defaults for those left out."""
Seed = Annotated[int, Field(ge=0, lt=2**53)]


class Model(BaseModel):
    model_config = ConfigDict(from_attributes=True, extra="forbid")


class Page(BaseModel, Generic[T]):
    """A list of things."""

    items: list[T]
