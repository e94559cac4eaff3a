"""A finding: what a look at the pairs says of them, with one sentence on what to do."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any


@dataclass(frozen=True)
class Finding:
    """The answer to one question about some pairs."""

    name: str
    """copies, hidden, ambiguous or thin."""
    found: bool
    """Whether there is something to do."""
    measure: float
    """The figure it was decided by; what it is says the module that asks."""
    sentence: str
    """For the demonstrator: what it is, and what to do where something was found."""
    details: Mapping[str, Any] = field(default_factory=dict)
    """More figures, as JSON holds them."""


def plain(name: str) -> str:
    """The name of a component as a person reads it."""
    return name.replace("_", " ")
