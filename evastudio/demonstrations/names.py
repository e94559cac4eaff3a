"""Names and notes, as people write them and the store keeps them."""

from __future__ import annotations

from evastudio.errors import InvalidInputError

NAME_LENGTH = 200
NOTE_LENGTH = 2000


def checked_name(name: str, what: str) -> str:
    """`name` without blanks around it. Raises InvalidInputError for one that cannot be kept."""
    name = name.strip()
    if not 0 < len(name) <= NAME_LENGTH or not name.isprintable():
        raise InvalidInputError(
            f"The name of a {what} is {name[:40]!r}; it must have 1 to {NAME_LENGTH} printable "
            "characters."
        )
    return name


def checked_note(note: str) -> str:
    """`note` without blanks around it. Raises InvalidInputError for one that cannot be kept."""
    note = note.strip()
    if len(note) > NOTE_LENGTH or any(not (sign.isprintable() or sign == "\n") for sign in note):
        raise InvalidInputError(
            f"The note has {len(note)} characters; it may have {NOTE_LENGTH}, all printable."
        )
    return note
