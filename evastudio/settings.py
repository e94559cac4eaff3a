"""How a studio is run: what the command line and scripts may set."""

from __future__ import annotations

import secrets
from dataclasses import dataclass, field

from evastudio.errors import InvalidInputError
from evastudio.workspace import Workspace

DEFAULT_PORT = 8400
MIN_TOKEN = 16


@dataclass(frozen=True)
class Settings:
    """Settings of the server."""

    workspace: Workspace
    host: str = "127.0.0.1"
    port: int = DEFAULT_PORT
    """0 takes any free one."""
    token: str = field(default_factory=lambda: secrets.token_urlsafe(24), repr=False)
    """Who knows it may do everything."""
    browser: bool = True
    """Open the page once the server listens."""

    def __post_init__(self) -> None:
        if not 0 <= self.port <= 65535:
            raise InvalidInputError(f"The port is {self.port}; it must be from 0 to 65535.")
        if len(self.token) < MIN_TOKEN or not self.token.isascii() or not self.token.isprintable():
            raise InvalidInputError(
                f"The token has {len(self.token)} characters; it needs at least {MIN_TOKEN} plain "
                "ones, or leave --token away to get one."
            )
        if any(character in self.token for character in ' ;,"\\'):
            raise InvalidInputError("The token may not hold spaces, quotes, commas or semicolons.")
