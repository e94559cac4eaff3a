"""How a studio is run: what the command line and scripts may set."""

from __future__ import annotations

import secrets
from dataclasses import dataclass, field
from urllib.parse import urlsplit

from evastudio.errors import InvalidInputError
from evastudio.logs import Logs
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
    remember: bool = False
    """Let browsers in that came in by the token of an earlier run. Not for a token somebody chose:
    choosing another is how to lock them out."""
    public_url: str | None = None
    """Scheme and host, as https://studio.example, where a proxy in front of it shows it so."""
    behind_proxy: str | None = None
    """Addresses of proxies whose X-Forwarded-For is believed, with commas between, or None."""
    browser: bool = True
    """Open the page once the server listens."""
    logs: Logs = field(default_factory=Logs)
    """How it writes what happens."""

    def __post_init__(self) -> None:
        if not 0 <= self.port <= 65535:
            raise InvalidInputError(f"The port is {self.port}; it must be from 0 to 65535.")
        if self.public_url is not None:
            object.__setattr__(self, "public_url", _public(self.public_url))
        if len(self.token) < MIN_TOKEN or not self.token.isascii() or not self.token.isprintable():
            raise InvalidInputError(
                f"The token has {len(self.token)} characters; it needs at least {MIN_TOKEN} plain "
                "ones, or leave --token away to get one."
            )
        if any(character in self.token for character in ' ;,"\\'):
            raise InvalidInputError("The token may not hold spaces, quotes, commas or semicolons.")

    @property
    def local(self) -> bool:
        """Whether only this machine reaches it."""
        return self.host.strip("[]").lower() in {"127.0.0.1", "localhost", "::1"}

    @property
    def exposure(self) -> str | None:
        """One sentence on who can reach the studio, where that is not only this machine."""
        if self.public_url is not None:
            return (
                f"Whoever reaches {self.public_url} and has the token can do everything here: "
                "record, delete, and run work on this machine."
            )
        if self.local:
            return None
        return (
            f"Whoever reaches this machine at {self.host} and has the token can do everything "
            "here: record, delete, and run work on this machine; and whoever listens on the way "
            "can read the token, for nothing is encrypted (docs/security.md says how to change "
            "that)."
        )


def _public(url: str) -> str:
    """`url` as browsers write an origin. Raises InvalidInputError."""
    try:
        parts = urlsplit(url)
        name, port = parts.hostname, parts.port
    except ValueError:  # half an IPv6 address, a port that is none
        parts, name, port = urlsplit(""), None, None
    if (
        parts.scheme not in {"http", "https"}
        or not name
        or parts.path not in {"", "/"}
        or parts.username is not None
        or parts.query
        or parts.fragment
    ):
        raise InvalidInputError(
            f"The public address is {url!r}; it must be a scheme and a host, with a port where it "
            "needs one, as https://studio.example."
        )
    host = f"[{name}]" if ":" in name else name
    usual = {"http": 80, "https": 443}[parts.scheme]
    return f"{parts.scheme}://{host}" + ("" if port in {None, usual} else f":{port}")
