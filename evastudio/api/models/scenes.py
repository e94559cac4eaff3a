"""Scenes over HTTP, field by field."""

from __future__ import annotations

from collections.abc import Sequence

from pydantic import BaseModel

from evastudio.api.models.common import Model


class OptionOut(Model):
    name: str
    label: str
    default: float
    low: float
    high: float
    step: float
    help: str


class ControlOut(Model):
    field: str
    label: str
    negative: Sequence[str]
    positive: Sequence[str]
    ramp_s: float
    """Seconds from rest to where a held key leads."""
    reach: float
    """Where a held key leads, in shares of the full deflection."""


class FieldOut(BaseModel):
    name: str
    unit: str
    low: float | None
    """None where there is no bound."""
    high: float | None


class PerceptionOut(BaseModel):
    name: str
    summary: str
    state: list[FieldOut]


class SignalOut(BaseModel):
    name: str
    label: str
    key: str
    placed: bool
    """Whether it is meant at a place on the ground."""


class EventOut(BaseModel):
    name: str
    label: str
    """What a person reads where it is so."""


class SceneOut(BaseModel):
    name: str
    title: str
    version: int
    dt_s: float
    outcomes: list[str]
    successes: list[str]
    options: list[OptionOut]
    controls: list[ControlOut]
    signals: list[SignalOut]
    events: list[EventOut]
    """What a switch between policies can hang on."""
    action: list[FieldOut]
    """In the world's frame; empty where that is one of a set of symbols."""
    symbols: list[str]
    """What it chooses among under its first perception; empty where it chooses numbers."""
    perceptions: list[PerceptionOut]
    many: bool
    """Whether many characters share a world, of which a person guides one."""
    people: bool
    """Whether it shows people, who move as the chosen clips say."""
