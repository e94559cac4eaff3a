"""The door: by which names the server is reached, and what its cookie is like."""

from __future__ import annotations

import ipaddress
import socket
from dataclasses import dataclass
from urllib.parse import urlsplit

ANY_HOST = frozenset({"0.0.0.0", "::", "[::]"})


@dataclass(frozen=True)
class Door:
    """What the guard needs to know of where the server stands."""

    host: str
    """The address the server is bound to."""
    port: int
    public_url: str | None = None
    """Scheme and host under which a proxy in front shows it, or None."""

    def admits_host(self, host_header: str) -> bool:
        """Whether a request addressed to that host is meant for this server (DNS rebinding)."""
        try:
            name = urlsplit(f"//{host_header}").hostname or ""
        except ValueError:  # half an IPv6 address
            return False
        if self.is_public(host_header):
            return True
        if name in {"localhost", "127.0.0.1", "::1", self.host.strip("[]").lower()}:
            return True
        if self.host not in ANY_HOST:
            return False
        try:
            ipaddress.ip_address(name)
        except ValueError:
            return name == socket.gethostname().lower()
        return True

    def is_public(self, host_header: str) -> bool:
        """Whether a request came to the public name."""
        if self.public_url is None:
            return False
        return host_header.lower() == self.public_url.partition("://")[2]

    def origin(self, host_header: str) -> str:
        """The one origin that pages of this server have, when reached so."""
        public = self.public_url if self.is_public(host_header) else None
        return public or f"http://{host_header}"

    def secure(self, host_header: str) -> bool:
        """Whether browsers reach it encrypted."""
        return self.origin(host_header).startswith("https:")

    def cookie(self, host_header: str) -> str:
        """Cookies ignore ports, so the name tells them apart; browsers guard that prefix."""
        return f"{'__Host-' if self.secure(host_header) else ''}evastudio-{self.port}"
