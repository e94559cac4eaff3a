"""The errors a user can meet: each says what was given, what was expected and what to do."""

from __future__ import annotations

import difflib
from collections.abc import Iterable


class StudioError(Exception):
    """Base of every error that is meant to be read by a person."""


class InvalidInputError(StudioError, ValueError):
    """Something from outside (a file, a number, a request) is not what it must be."""


class NotFoundError(StudioError, LookupError):
    """A name or an identifier that nothing answers to."""


class ConflictError(StudioError, ValueError):
    """The request is well formed, but not possible in the present state."""


class BusyError(ConflictError):
    """The request would be possible at another time: there is too much of its kind now."""


class StorageError(StudioError, ValueError):
    """A workspace, database or policy file that cannot be read or written."""


class ClusterError(StudioError, ConnectionError):
    """A cluster that cannot be reached, or whose workers cannot do the work."""


class AccessError(StudioError, PermissionError):
    """A studio that does not let one in, or not do that."""


class UnreachableError(StudioError, ConnectionError):
    """A studio that does not answer."""


class JobError(StudioError, RuntimeError):
    """A job that ended without its result."""


def not_found(kind: str, name: object, known: Iterable[str], where: str = "") -> NotFoundError:
    """The error for an unknown name, with the closest known ones; `where` as "of scene 'x'"."""
    names = sorted(known)
    close = difflib.get_close_matches(str(name), names, n=1)
    hint = f" Did you mean {close[0]!r}?" if close else ""
    listed = ", ".join(names[:12]) + (", ..." if len(names) > 12 else "") if names else "none"
    place = f" {where}" if where else ""
    return NotFoundError(f"There is no {kind} {str(name)!r}{place}.{hint} Known: {listed}.")
