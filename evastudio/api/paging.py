"""Pages of lists: at most `limit` items, from the one after that at which the last page ended."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Annotated, Any, TypeVar

from fastapi import Depends, Query
from pydantic import BaseModel

from evastudio.api.models.common import Page

M = TypeVar("M", bound=BaseModel)
R = TypeVar("R")
Limit = Annotated[int, Query(ge=1, le=1000, description="Items at most.")]


class ByNumber:
    """Which page of things that are numbered."""

    def __init__(
        self,
        limit: Limit = 100,
        cursor: Annotated[
            int | None, Query(ge=1, lt=2**31, description="`next` of the page before.")
        ] = None,
    ) -> None:
        self.limit = limit
        self.cursor = cursor

    def page(self, model: type[M], load: Callable[[int | None, int], Sequence[Any]]) -> Page[M]:
        """The page of what `load(after, limit)` gives; its items have an `id`."""
        found = load(self.cursor, self.limit + 1)
        shown = found[: self.limit]
        more = shown[-1].id if len(found) > self.limit else None
        return Page(items=[model.model_validate(one) for one in shown], next=more)


class ByName:
    """Which page of things that have names."""

    def __init__(
        self,
        limit: Limit = 100,
        cursor: Annotated[
            str | None, Query(max_length=200, description="`next` of the page before.")
        ] = None,
    ) -> None:
        self.limit = limit
        self.cursor = cursor

    def page(
        self, everything: Sequence[R], name: Callable[[R], str], shown: Callable[[R], M]
    ) -> Page[M]:
        """The page of `everything` in its order; a cursor that is gone begins anew."""
        names = [name(one) for one in everything]
        first = names.index(self.cursor) + 1 if self.cursor in names else 0
        items = everything[first : first + self.limit]
        more = first + self.limit < len(everything)
        return Page(items=[shown(one) for one in items], next=name(items[-1]) if more else None)


NumberedPage = Annotated[ByNumber, Depends()]
NamedPage = Annotated[ByName, Depends()]
