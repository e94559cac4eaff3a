"""Pairs over HTTP, field by field."""

from __future__ import annotations

from evastudio.api.models.common import Model


class PairsOut(Model):
    state: list[str]
    """What the numbers of a state are."""
    action: list[str]
    states: list[list[float]]
    actions: list[list[float]]
    """In the character's own frame; of symbols their codes."""
    takes: list[int]
    """The take each came from."""
    steps: list[int]
    """Its decision step there."""
    conflicts: list[bool]
    """Whether cleaning marked it."""
    corrections: list[bool]
    """Whether somebody showed it who had taken over from a policy."""
