"""Answers as dataclasses: what a newer studio tells besides is left out."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields
from typing import Any, TypeVar

from evastudio.errors import StudioError

T = TypeVar("T")


def read(kind: type[T], told: Mapping[str, Any], **others: Any) -> T:
    """A `kind` of what is `told`, and `others` besides. Raises StudioError where a field lacks."""
    names = [field.name for field in fields(kind)]  # type: ignore[arg-type]
    known = {name: told[name] for name in names if name in told}
    try:
        return kind(**{**known, **others})
    except TypeError as error:
        raise StudioError(
            f"The studio's answer is not what this client expects ({error}). Use a client of the "
            "studio's own version."
        ) from None
