"""What every room of the API shares."""

from __future__ import annotations

from typing import Annotated, Generic, Literal, TypeVar

from pydantic import AfterValidator, BaseModel, ConfigDict, Field, FiniteFloat

T = TypeVar("T")
Delay = Annotated[float, Field(ge=0.0, le=2.0)] | Literal["auto", "off"]
"""Reaction delay to take out: as estimated where that helps, none, or so many seconds."""
Name = Annotated[str, Field(min_length=1, max_length=200)]
PolicyName = Annotated[
    str,
    Field(max_length=80, json_schema_extra={"pattern": "^[a-z0-9][a-z0-9._-]{0,79}$"}),
]
"""What a policy can be called. The pattern is told; who does not keep to it reads a sentence."""
Options = Annotated[dict[Name, FiniteFloat], Field(default_factory=dict, max_length=100)]
"""Of a scene, by name; its own defaults for those left out."""
Seed = Annotated[int, Field(ge=0, lt=2**53)]


def at_most(count: int) -> AfterValidator:
    """That a list has at most `count` items. Not in the schema: nobody need try so many."""

    def check(items: list[T]) -> list[T]:
        if len(items) > count:
            raise ValueError(f"there are {len(items)}; send at most {count} at once")
        return items

    return AfterValidator(check)


class Model(BaseModel):
    model_config = ConfigDict(from_attributes=True, extra="forbid")


class Given(Model):
    """What a client gives: of the types that are asked for, not of what could be made into them."""

    model_config = ConfigDict(strict=True)


class Page(BaseModel, Generic[T]):
    """A part of a list of things."""

    items: list[T]
    next: int | str | None = None
    """The `cursor` that gives the items after these; None where there are no more."""
