"""Named tokens: whom a team lets into its studio, and what each may do. Kept in its store."""

from __future__ import annotations

import hashlib
import hmac
import secrets
from dataclasses import dataclass
from enum import StrEnum

from sqlalchemy import ColumnElement, Row, insert, select, update

from evastudio.demonstrations import schema
from evastudio.demonstrations.engine import writing
from evastudio.demonstrations.store import Store
from evastudio.errors import ConflictError, InvalidInputError, NotFoundError

NAME_LENGTH = 80


class Role(StrEnum):
    """What somebody may do."""

    AUTHOR = "author"
    """Everything."""
    VIEWER = "viewer"
    """Watch, compare and vote; change nothing."""


@dataclass(frozen=True)
class Token:
    """A token without its secret, which nobody keeps."""

    id: int
    name: str
    """Of whom it was made for."""
    role: Role
    created_at: float
    """Seconds since the epoch."""
    revoked_at: float | None
    """When it ceased to be good, or None."""


def new_secret() -> str:
    """A token that cannot be guessed: 256 random bits, as letters that fit into an address."""
    return secrets.token_urlsafe(32)


def digest(secret: str) -> str:
    """What is kept of a secret.

    Plain SHA-256 is enough: secrets are random, so there is no list of likely ones to try.
    """
    return hashlib.sha256(secret.encode("utf-8", "surrogatepass")).hexdigest()


def cookie_of(secret: str) -> str:
    """What a browser keeps in place of the token: made from it, and it cannot be made from this.

    Nothing has to be remembered for it, it ends with its token, and whoever steals it has no token.
    """
    return hmac.new(secret.encode(), b"evastudio cookie", hashlib.sha256).hexdigest()


class Tokens:
    """The named tokens of a store. Safe to use from several threads and programs."""

    def __init__(self, store: Store) -> None:
        self._engine = store.engine

    def add(self, name: str, role: Role, now: float) -> str:
        """Let `name` in from now on, seconds since the epoch; the secret, told this once.

        Raises InvalidInputError for a name that is none, ConflictError for one that has a token.
        """
        if not name.strip() or len(name) > NAME_LENGTH or not name.isprintable():
            raise InvalidInputError(
                f"The name {name[:NAME_LENGTH]!r} must have 1 to {NAME_LENGTH} letters that can be "
                "printed."
            )
        table, secret = schema.tokens, new_secret()
        with writing(self._engine) as connection:
            if connection.execute(select(table.c.id).where(_good(name))).first() is not None:
                raise ConflictError(
                    f"{name!r} has a token already; revoke that first, or choose another name."
                )
            connection.execute(
                insert(table).values(
                    name=name,
                    role=role.value,
                    digest=digest(secret),
                    cookie=digest(cookie_of(secret)),
                    created_at=now,
                )
            )
        return secret

    def all(self) -> list[Token]:
        """Every token there was, the oldest first."""
        with self._engine.connect() as connection:
            rows = connection.execute(select(schema.tokens).order_by(schema.tokens.c.id))
            return [_token(row) for row in rows]

    def revoke(self, name: str, now: float) -> None:
        """Let `name` in no longer. Raises NotFoundError where that has no token."""
        with writing(self._engine) as connection:
            changed = connection.execute(
                update(schema.tokens).where(_good(name)).values(revoked_at=now)
            )
        if changed.rowcount == 0:
            raise NotFoundError(f"{name!r} has no token; `evastudio tokens` lists them.")

    def holder(self, secret: str, cookie: bool = False) -> Token | None:
        """Whose secret, or cookie, that is, if it is good now."""
        table = schema.tokens
        column, asked = (table.c.cookie if cookie else table.c.digest), digest(secret)
        query = select(table).where(column == asked, table.c.revoked_at.is_(None))
        with self._engine.connect() as connection:
            row = connection.execute(query).one_or_none()
        # That the index looks a digest up in no constant time tells nothing of the secret.
        if row is None or not hmac.compare_digest(row.cookie if cookie else row.digest, asked):
            return None
        return _token(row)

    def good(self) -> set[int]:
        """The ids of all that are good now."""
        query = select(schema.tokens.c.id).where(schema.tokens.c.revoked_at.is_(None))
        with self._engine.connect() as connection:
            return set(connection.execute(query).scalars())


def _good(name: str) -> ColumnElement[bool]:
    return (schema.tokens.c.name == name) & schema.tokens.c.revoked_at.is_(None)


def _token(row: Row[tuple[object, ...]]) -> Token:
    return Token(row.id, row.name, Role(row.role), row.created_at, row.revoked_at)
