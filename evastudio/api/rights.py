"""Rights: what a viewer may do beside reading. Whatever is not listed here, only an author may."""

from __future__ import annotations

import re

from evastudio.live.tokens import Role

VOTES = ("POST", "/api/v1/ballots/{ballot}/votes")
"""All that a viewer puts into the store."""
READING = frozenset({"GET", "HEAD", "OPTIONS"})
"""Methods that change nothing, here as everywhere."""
SOCKET = "websocket"
VIEWERS_MAY: tuple[tuple[str, str], ...] = (
    ("POST", "/api/v1/policies/{name}/decide"),
    ("POST", "/api/v1/policies/{name}/explain"),
    ("POST", "/api/v1/lineups"),
    ("POST", "/api/v1/lineups/{lineup}/commands"),
    ("DELETE", "/api/v1/lineups/{lineup}"),
    ("POST", "/api/v1/ballots/{ballot}/showings"),
    VOTES,
    (SOCKET, "/view/{stage}"),
    (SOCKET, "/view/{stage}/"),
    (SOCKET, "/view/{stage}/{scheme}"),
    (SOCKET, "/view/{stage}/{scheme}/"),
    (SOCKET, "/api/v1/stages/{stage}/socket"),
)
"""Method, or SOCKET, and path as the route has it, of everything else that a viewer may do: watch
what an author does on a stage, ask a policy, look at lineups of their own, and vote. Their handlers
take in nothing that changes anything else.
"""
REFUSAL = (
    "You came in as a viewer, who may watch and read here but change nothing. Ask whoever runs "
    "this studio for an author's token (evastudio tokens add NAME --role author)."
)


def _pattern(path: str) -> re.Pattern[str]:
    return re.compile(re.sub(r"\\\{\w+\\\}", "[^/]+", re.escape(path)))


_OPEN = [(method, _pattern(path)) for method, path in VIEWERS_MAY]
_VOTES = _pattern(VOTES[1])


def may(role: Role, method: str, path: str) -> bool:
    """Whether somebody of that role may; `method` is SOCKET for a websocket."""
    if role is Role.AUTHOR or method in READING:
        return True
    return any(method == one and pattern.fullmatch(path) for one, pattern in _OPEN)


def writes(role: Role, path: str) -> bool:
    """Whether what is posted there changes what is kept, where it is allowed."""
    return role is Role.AUTHOR or _VOTES.fullmatch(path) is not None
