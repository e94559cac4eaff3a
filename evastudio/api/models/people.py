"""People over HTTP, field by field."""

from __future__ import annotations

from typing import Literal

from pydantic import BaseModel


class MeOut(BaseModel):
    name: str
    role: Literal["author", "viewer"]
