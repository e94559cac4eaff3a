"""Clips over HTTP, field by field."""

from __future__ import annotations

from evastudio.api.models.common import Given, Model, Name


class ClipFileOut(Model):
    name: str
    clips: list[str]
    problem: str | None
    """Why it cannot be used, or None."""


class ActivityOut(Model):
    name: str
    label: str
    file: str | None
    """None where people move as shipped."""
    clip: str | None
    problem: str | None
    """Why what was chosen cannot be played, or None."""


class ClipsOut(Model):
    folder: str
    """Where files of clips lie."""
    files: list[ClipFileOut]
    activities: list[ActivityOut]
    problem: str | None
    """Why the choices cannot be read, or None."""


class ClipIn(Given):
    file: Name
    clip: Name
