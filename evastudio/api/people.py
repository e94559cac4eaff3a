"""People: who is known to the server, by a token or by the cookie made from one."""

from __future__ import annotations

import asyncio
import hmac
import secrets
from dataclasses import dataclass
from typing import Annotated, cast

from fastapi import Depends
from starlette.requests import HTTPConnection

from evastudio.live.tokens import Role, Tokens, cookie_of, digest

CODE_S = 120.0
"""How long a code for the browser that the studio opens itself is good."""


@dataclass(frozen=True)
class Person:
    """Somebody who may come in."""

    name: str
    role: Role
    token: int | None
    """Id of the named token; None for that of this run."""

    @property
    def voter(self) -> str:
        """Who it is among those who vote and compare: whose token, or nobody by name."""
        return "" if self.token is None else self.name


@dataclass(frozen=True)
class Credential:
    """What somebody shows at the door."""

    secret: str
    cookie: bool
    """Whether it is a browser's cookie, and no token."""

    @property
    def digest(self) -> str:
        return digest(self.secret)


class People:
    """Whoever knows the token of this run, an author, and whoever has a token of the store.

    So is a browser that an earlier run let in, where the studio remembers those.
    """

    def __init__(self, token: str, tokens: Tokens, earlier: frozenset[str] = frozenset()) -> None:
        """`earlier` are the digests of cookies of earlier runs that are still good."""
        self._token = token
        self._earlier = earlier
        self._digests = {False: digest(token), True: digest(cookie_of(token))}
        self._tokens = tokens
        self._code: tuple[str, float] | None = None

    async def who(self, shown: Credential) -> Person | None:
        """Whose credential that is. Raises StorageError where the store cannot be asked."""
        if hmac.compare_digest(shown.digest, self._digests[shown.cookie]):
            return Person("Author", Role.AUTHOR, None)
        if shown.cookie and shown.digest in self._earlier:
            return Person("Author", Role.AUTHOR, None)
        found = await asyncio.to_thread(self._tokens.holder, shown.secret, shown.cookie)
        return None if found is None else Person(found.name, found.role, found.id)

    async def good(self) -> set[int]:
        """Ids of the named tokens that are good now. Raises StorageError."""
        return await asyncio.to_thread(self._tokens.good)

    def code(self, now: float) -> str:
        """A stand-in for the token of this run, good once and for two minutes.

        The address a browser is started with can be read by everybody on this machine.
        """
        code = secrets.token_urlsafe(32)
        self._code = (code, now + CODE_S)
        return code

    def redeem(self, given: str, now: float) -> str | None:
        """The token that a code stands for, where it is good."""
        if self._code is None:
            return None
        code, until = self._code
        if now > until or not hmac.compare_digest(digest(given), digest(code)):
            return None
        self._code = None
        return self._token


async def _person(connection: HTTPConnection) -> Person:
    return cast("Person", connection.scope["state"]["person"])


Visitor = Annotated[Person, Depends(_person)]
"""What a route declares to get who asks."""
