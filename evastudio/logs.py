"""What the program writes of what happens, to stderr: lines for people, or JSON, one event a line.

No names, no tokens, no addresses with their queries: of a request the route it came to, never the
path it asked for.
"""

from __future__ import annotations

import json
import logging
import sys
from contextvars import ContextVar
from dataclasses import dataclass
from datetime import UTC, datetime
from enum import StrEnum

request_id: ContextVar[str | None] = ContextVar("request_id", default=None)
"""Of the request that is being answered, which every event meanwhile is written with."""
FACTS = "facts"
"""Name in `extra` of a mapping that is written with an event, field by field."""


class Form(StrEnum):
    TEXT = "text"
    JSON = "json"


class Level(StrEnum):
    DEBUG = "debug"
    INFO = "info"
    WARNING = "warning"
    ERROR = "error"


@dataclass(frozen=True)
class Logs:
    """How events are written."""

    form: Form = Form.TEXT
    level: Level = Level.WARNING
    """Events below it are not written; each request is one of level info."""

    def begin(self) -> None:
        """Write so from now on, in this process."""
        handler = logging.StreamHandler(sys.stderr)
        text = "%(levelname)s %(name)s: %(message)s"
        handler.setFormatter(Lines() if self.form is Form.JSON else Words(text))
        root = logging.getLogger()
        root.handlers[:] = [handler]
        root.setLevel(self.level.upper())
        _present[:] = [self]


_present = [Logs()]


def present() -> Logs:
    """How this process writes events."""
    return _present[0]


class Words(logging.Formatter):
    """An event as a line of text, its facts and its request at the end."""

    def formatMessage(self, record: logging.LogRecord) -> str:  # noqa: N802 - logging's own name
        told = {**getattr(record, FACTS, {}), **_request()}
        facts = "".join(f" {name}={value}" for name, value in told.items())
        return super().formatMessage(record) + facts


class Lines(logging.Formatter):
    """An event as one JSON object on one line."""

    def format(self, record: logging.LogRecord) -> str:
        told = {
            "time": datetime.fromtimestamp(record.created, UTC).isoformat(timespec="milliseconds"),
            "level": record.levelname.lower(),
            "logger": record.name,
            "message": record.getMessage(),
            **getattr(record, FACTS, {}),
            **_request(),
        }
        if record.exc_info:
            told["exception"] = self.formatException(record.exc_info)
        return json.dumps(told, default=str)


def _request() -> dict[str, str]:
    present = request_id.get()
    return {} if present is None else {"request": present}
