"""Answers kept for a while, so that a request that comes again is not done again.

In the store, so that they outlive the server and hold for every studio on it.
"""

from __future__ import annotations

import hashlib
from dataclasses import dataclass

from sqlalchemy import delete, insert, select, update

from evastudio.demonstrations import schema
from evastudio.demonstrations.engine import writing
from evastudio.demonstrations.store import Store
from evastudio.errors import ConflictError, InvalidInputError

KEPT_S = 24 * 3600.0
"""For so long an answer is kept."""
ABANDONED_S = 60.0
"""A request that is not answered for so long was cut off with its server; it may be done again."""


@dataclass(frozen=True)
class Answer:
    """What was answered."""

    status: int
    media_type: str
    body: bytes


def digest_of(*parts: bytes) -> str:
    """SHA-256 of `parts` and their bounds, hexadecimal."""
    whole = hashlib.sha256()
    for part in parts:
        whole.update(len(part).to_bytes(8, "little"))
        whole.update(part)
    return whole.hexdigest()


class Answers:
    """The answers of a store. Safe to use from several threads and programs."""

    def __init__(self, store: Store) -> None:
        self._engine = store.engine

    def begin(self, key: str, digest: str, now: float) -> Answer | None:
        """The answer to the request `digest`, or None where it is to be done now.

        Raises ConflictError while it is being done, InvalidInputError where the key is another
        request's, StorageError. `now` in seconds since the epoch.
        """
        table = schema.answers
        with writing(self._engine) as connection:
            connection.execute(delete(table).where(table.c.started_at < now - KEPT_S))
            row = connection.execute(
                select(table).where(table.c.key == key).with_for_update()
            ).one_or_none()
            if row is None:
                connection.execute(insert(table).values(key=key, digest=digest, started_at=now))
                return None
            if row.digest != digest:
                raise InvalidInputError(
                    "This Idempotency-Key was sent with another request before; choose another "
                    "key for another request."
                )
            if row.status is not None:
                return Answer(row.status, row.media_type, row.body)
            if row.started_at > now - ABANDONED_S:
                raise ConflictError(
                    "The request with this Idempotency-Key is being done; ask again for its answer."
                )
            connection.execute(update(table).where(table.c.key == key).values(started_at=now))
            return None

    def keep(self, key: str, answer: Answer) -> None:
        """Answer so when the request comes again. Raises StorageError."""
        table = schema.answers
        values = {
            "status": answer.status,
            "media_type": answer.media_type,
            "body": answer.body,
        }
        with writing(self._engine) as connection:
            connection.execute(update(table).where(table.c.key == key).values(**values))

    def forget(self, key: str) -> None:
        """Let the request be done again: it came to nothing. Raises StorageError."""
        table = schema.answers
        with writing(self._engine) as connection:
            connection.execute(delete(table).where(table.c.key == key, table.c.status.is_(None)))
