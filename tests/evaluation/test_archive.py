"""Stored evaluations: whole, found again, and the same bit for bit when they are repeated."""

from __future__ import annotations

import sqlite3
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from evastudio.demonstrations.store import Store
from evastudio.errors import NotFoundError, StorageError
from evastudio.evaluation.archive import (
    differing,
    evaluations,
    find_evaluation,
    save_evaluation,
)
from evastudio.evaluation.evaluate import evaluate
from evastudio.evaluation.results import Comparison
from evastudio.evaluation.versions import versions
from evastudio.pilots.scripted import find_pilot
from evastudio.world.scene import Scene


def compared(scene: Scene, seed: int = 2) -> Comparison:
    pilots = {name: find_pilot(name) for name in ("straight", "scripted:careful")}
    return evaluate(
        scene, pilots, worlds=4, seed=seed, like="straight", max_steps=200, measure_time=False
    )


def test_an_evaluation_comes_back_as_it_was(asteroids: Callable[..., Scene], store: Store) -> None:
    first = compared(asteroids(density=6.0))
    number = save_evaluation(store, first, {"seed": 2}, 12.5)
    record, back = find_evaluation(store, number)
    assert back.to_json() == first.to_json() == record.result
    assert differing(first, back) == []
    assert (record.scene, record.created_at, record.asked) == ("asteroids", 12.5, {"seed": 2})
    assert record.versions == versions()
    other = save_evaluation(store, compared(asteroids(density=5.0)), {}, 13.0)
    assert [one.id for one in evaluations(store)] == [other, number]
    assert evaluations(store, "crowd") == []


def test_what_differs_is_named(asteroids: Callable[..., Scene]) -> None:
    first, again = compared(asteroids(density=6.0)), compared(asteroids(density=6.0))
    assert differing(first, again) == []
    again.pilots["straight"].outcomes[2] += 1
    turn = again.pilots["scripted:careful"].figures["turn"]
    turn[0] = np.nextafter(turn[0], 1.0)
    assert differing(first, again) == ["straight: outcomes", "scripted:careful: turn"]


def test_an_evaluation_that_is_not_there_or_damaged_is_told(
    asteroids: Callable[..., Scene], tmp_path: Path
) -> None:
    path = tmp_path / "studio.db"
    with Store(f"sqlite:///{path}") as store:
        for number in (1, 0, -3, 2**40):
            with pytest.raises(NotFoundError, match=f"no evaluation {number}"):
                find_evaluation(store, number)
        number = save_evaluation(store, compared(asteroids()), {}, 1.0)
        with sqlite3.connect(path) as connection:
            connection.execute("update evaluations set arrays = x'00ff'")
        with pytest.raises(StorageError, match="damaged"):
            find_evaluation(store, number)


def test_a_store_of_the_first_version_gets_its_table(
    asteroids: Callable[..., Scene], tmp_path: Path
) -> None:
    path = tmp_path / "studio.db"
    with Store(f"sqlite:///{path}") as store:
        store.create_session(asteroids(), "Kept", "test", 1.0)
    with sqlite3.connect(path) as connection:
        connection.execute("drop table evaluations")
        connection.execute("update evastudio_store set version = 1")
    with Store(f"sqlite:///{path}") as store:
        assert evaluations(store) == []
        assert store.session("Kept").name == "Kept"
        assert save_evaluation(store, compared(asteroids()), {}, 1.0) == 1
