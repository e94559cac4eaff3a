"""How long a store takes: each statement by its kind, and each use of a connection whole."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

from sqlalchemy import Engine, event

KINDS = frozenset({"select", "insert", "update", "delete", "begin"})
OTHER = "other"
WHOLE = "transaction"
"""From taking a connection to giving it back, commit and waiting for others' writes included."""
BEGAN = "evastudio_began"


def watch_store(engine: Engine, observe: Callable[[str, float], None]) -> None:
    """Call `observe` with the kind and the seconds of everything that `engine` does from now on."""

    def before(connection: Any, *_: Any) -> None:
        connection.info[BEGAN] = time.perf_counter()

    def after(connection: Any, _: Any, statement: str, *__: Any) -> None:
        kind = statement.lstrip().partition(" ")[0].lower()
        seconds = time.perf_counter() - connection.info[BEGAN]
        observe(kind if kind in KINDS else OTHER, seconds)

    def taken(_: Any, record: Any, __: Any) -> None:
        record.info[WHOLE] = time.perf_counter()

    def given_back(_: Any, record: Any) -> None:
        began = record.info.pop(WHOLE, None)
        if began is not None:
            observe(WHOLE, time.perf_counter() - began)

    event.listen(engine, "before_cursor_execute", before)
    event.listen(engine, "after_cursor_execute", after)
    event.listen(engine, "checkout", taken)
    event.listen(engine, "checkin", given_back)
