"""Limits: how much one request, one person and everybody together may ask of the server."""

from __future__ import annotations

MOST_BODY_BYTES = 1_000_000
"""Of a body, unless its route declares more (`max_body_size`)."""
MOST_UPLOAD_BYTES = 64_000_000
"""What a route that takes arrays declares."""
MOST_JSON_BYTES = 8_000_000
"""Of JSON among them: read, it takes several times as much memory as arrays do."""
MOST_TARGET_BYTES = 4_000
"""Of path and query."""
MOST_HEAD_BYTES = 16_384
"""Of the first line and the headers together."""
MOST_MESSAGE_BYTES = 2 * 2**20
"""Of one message through a websocket, unless its route wants less."""
HEAD_S = 10.0
"""Until the head of a request must be whole."""
BODY_S = 20.0
"""Until a body must be there, and besides a second for each `SLOWEST_BYTES` of it."""
SLOWEST_BYTES = 32_000
MOST_CONNECTIONS = 1000
SOCKETS_EACH, SOCKETS_ALL = 200, 500
"""Websockets open at once by one token, and by all."""
REQUESTS_EACH, REQUESTS_ALL = 128, 300
"""Requests answered at once, likewise."""
RETRY_S = 2
"""What a client that came at a bad time is told to wait."""
