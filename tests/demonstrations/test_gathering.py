"""Writes of many threads share commits, and none is answered before, or by another's failure."""

from __future__ import annotations

import threading
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor

import pytest
from sqlalchemy import Connection, insert, select

from evastudio.demonstrations import gathering as gatherings
from evastudio.demonstrations import schema
from evastudio.demonstrations.gathering import Gathering
from evastudio.demonstrations.store import Store
from evastudio.errors import NotFoundError

WAIT_S = 60.0
WRONG = "wrong"


class Notes:
    """Writes studies as they come, and remembers in which company; the first ones wait."""

    def __init__(self) -> None:
        self.together: list[list[str]] = []
        self.begun, self.go_on = threading.Event(), threading.Event()

    def __call__(self, connection: Connection, scenes: Sequence[str]) -> None:
        self.begun.set()
        assert self.go_on.wait(WAIT_S)
        rows = [{"scene": scene, "created_at": 0.0, "told": "{}"} for scene in scenes]
        connection.execute(insert(schema.studies), rows)
        if WRONG in scenes:
            raise NotFoundError("There is no such take.")
        self.together.append(sorted(scenes))


def kept(store: Store) -> list[str]:
    with store.engine.connect() as connection:
        return sorted(connection.execute(select(schema.studies.c.scene)).scalars())


def test_those_who_wait_are_written_together_and_a_failure_is_ones_own(store: Store) -> None:
    notes = Notes()
    gathering = Gathering(store.engine, notes)
    with ThreadPoolExecutor(8) as threads:
        first = threads.submit(gathering.write, "first")
        assert notes.begun.wait(WAIT_S)
        others = [threads.submit(gathering.write, str(number)) for number in range(5)]
        while len(gathering._waiting) < 5:
            assert not first.done()
        notes.go_on.set()
        for other in (first, *others):
            other.result(WAIT_S)
        assert notes.together == [["first"], ["0", "1", "2", "3", "4"]]

        notes.begun.clear()
        notes.go_on.clear()
        first = threads.submit(gathering.write, "second")
        assert notes.begun.wait(WAIT_S)
        wrong, right = (threads.submit(gathering.write, one) for one in (WRONG, "right"))
        while len(gathering._waiting) < 2:
            assert not first.done()
        notes.go_on.set()
        right.result(WAIT_S)
        with pytest.raises(NotFoundError):
            wrong.result(WAIT_S)
    assert kept(store) == ["0", "1", "2", "3", "4", "first", "right", "second"]


def test_who_is_patient_waits_for_others_and_for_nobody_in_a_hurry(
    store: Store, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(gatherings, "BETWEEN_S", 10 * WAIT_S)
    notes = Notes()
    notes.go_on.set()
    gathering = Gathering(store.engine, notes)
    gathering.write("first", patient=True)  # nobody wrote before: there is nothing to wait for
    with ThreadPoolExecutor(3) as threads:
        patient = [threads.submit(gathering.write, one, patient=True) for one in "ab"]
        while len(gathering._waiting) < 2:
            assert not any(one.done() for one in patient)
        for one in (threads.submit(gathering.write, "now"), *patient):
            one.result(WAIT_S)
    assert notes.together == [["first"], ["a", "b", "now"]]


def test_many_threads_write_at_once_and_none_waits_in_vain(store: Store) -> None:
    notes = Notes()
    notes.go_on.set()
    gathering = Gathering(store.engine, notes)

    def some(first: int) -> None:
        for number in range(first, first + 10):
            gathering.write(f"{number:03}")

    with ThreadPoolExecutor(20) as threads:
        for done in [threads.submit(some, 10 * worker) for worker in range(20)]:
            done.result(WAIT_S)
    assert kept(store) == [f"{number:03}" for number in range(200)]
