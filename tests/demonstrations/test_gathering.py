"""Writes of many threads share commits, and none is answered before, or by another's failure."""

from __future__ import annotations

import threading
from concurrent.futures import ThreadPoolExecutor

import pytest
from sqlalchemy import Connection, event, func, insert, select

from evastudio.demonstrations import schema
from evastudio.demonstrations.gathering import Gathering
from evastudio.demonstrations.store import Store
from evastudio.errors import NotFoundError

WAIT_S = 60.0


def note(number: int) -> dict[str, object]:
    return {"scene": f"scene {number}", "created_at": 0.0, "told": "{}"}


def test_those_who_wait_are_written_together_and_a_failure_is_ones_own(store: Store) -> None:
    gathering, begun, go_on = Gathering(store.engine), threading.Event(), threading.Event()
    commits: list[int] = []
    event.listen(store.engine, "commit", lambda connection: commits.append(1))

    def slowly(connection: Connection) -> None:
        connection.execute(insert(schema.studies).values(note(0)))
        begun.set()
        assert go_on.wait(WAIT_S)

    def wrongly(connection: Connection) -> None:
        connection.execute(insert(schema.studies).values(note(-1)))
        raise NotFoundError("There is no such take.")

    def simply(number: int) -> None:
        gathering.write(lambda one: one.execute(insert(schema.studies).values(note(number))))

    with ThreadPoolExecutor(8) as threads:
        first = threads.submit(gathering.write, slowly)
        assert begun.wait(WAIT_S)
        others = [threads.submit(simply, number) for number in range(1, 6)]
        while len(gathering._waiting) < 5:
            assert not first.done()
        go_on.set()
        for other in (first, *others):
            other.result(WAIT_S)
        assert len(commits) == 2

        begun.clear()
        go_on.clear()
        first = threads.submit(gathering.write, slowly)
        assert begun.wait(WAIT_S)
        wrong, right = threads.submit(gathering.write, wrongly), threads.submit(simply, 6)
        while len(gathering._waiting) < 2:
            assert not first.done()
        go_on.set()
        right.result(WAIT_S)
        with pytest.raises(NotFoundError):
            wrong.result(WAIT_S)
    with store.engine.connect() as connection:
        kept = connection.execute(select(schema.studies.c.scene)).scalars().all()
        count = connection.execute(select(func.count()).select_from(schema.studies)).scalar()
    assert sorted(kept) == sorted([f"scene {number}" for number in (0, 0, 1, 2, 3, 4, 5, 6)])
    assert count == 8


def test_many_threads_write_at_once_and_none_waits_in_vain(store: Store) -> None:
    gathering = Gathering(store.engine)

    def some(first: int) -> None:
        for number in range(first, first + 20):
            gathering.write(lambda one: one.execute(insert(schema.studies).values(note(number))))  # noqa: B023

    with ThreadPoolExecutor(30) as threads:
        for done in [threads.submit(some, 20 * worker) for worker in range(30)]:
            done.result(WAIT_S)
    with store.engine.connect() as connection:
        kept = connection.execute(select(schema.studies.c.scene)).scalars().all()
    assert sorted(kept) == sorted(f"scene {number}" for number in range(600))
