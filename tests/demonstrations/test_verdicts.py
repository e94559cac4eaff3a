"""What people say of single pairs: kept in the store, heeded by cleanings, gone with its take."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from evastudio.demonstrations.by_hand import mark_by_hand
from evastudio.demonstrations.records import Verdict
from evastudio.demonstrations.store import Store
from evastudio.demonstrations.verdicts import judged
from evastudio.errors import InvalidInputError, NotFoundError
from evastudio.world.scene import Scene


@pytest.fixture
def takes(store: Store, asteroids: Callable[..., Scene]) -> tuple[int, list[int]]:
    """A session of two takes of ten pairs; its id, and theirs."""
    scene = asteroids()
    session = store.create_session(scene, "Said", "test", 0.0)
    world, made = scene.worlds([1]), []
    view = scene.perception()
    states = view.perceive(world).states
    for _ in range(2):
        take = store.begin_take(session, scene, view.name, 1, "test", world.fixed, 0.0)
        moving = {name: np.repeat(array, 10, axis=0) for name, array in world.moving.items()}
        store.append(take, 0, np.repeat(states, 10, axis=0), np.zeros((10, 2)), moving)
        store.finish_take(take, None, 1.0)
        made.append(take)
    return session, made


def test_the_last_word_counts_until_it_is_withdrawn(
    store: Store, takes: tuple[int, list[int]]
) -> None:
    session, (first, second) = takes
    store.judge(second, 3, Verdict.KEEP)
    store.judge(first, 9, Verdict.DELETE)
    store.judge(second, 3, Verdict.MISSING)
    said = {(first, 9): Verdict.DELETE, (second, 3): Verdict.MISSING}
    assert list(store.verdicts(session).items()) == list(said.items())
    store.judge(first, 9, None)
    store.judge(first, 9, None)
    assert store.verdicts(session) == {(second, 3): Verdict.MISSING}
    with pytest.raises(InvalidInputError, match="has no moment 10"):
        store.judge(first, 10, Verdict.KEEP)
    with pytest.raises(NotFoundError):
        store.judge(999, 0, Verdict.KEEP)


def test_what_was_said_of_a_take_rests_with_it_in_the_trash_and_goes_with_it(
    store: Store, takes: tuple[int, list[int]]
) -> None:
    session, (first, _) = takes
    store.judge(first, 2, Verdict.KEEP)
    store.trash_take(first, 1.0)
    assert store.verdicts(session) == {}
    store.restore_take(first)
    assert store.verdicts(session) == {(first, 2): Verdict.KEEP}
    store.trash_take(first, 1.0)
    assert store.empty_trash(session) == 1
    assert store.verdicts(session) == {}


def test_marks_follow_what_was_said() -> None:
    marks = {7: np.array([True, True, False])}
    said = {
        (7, 0): Verdict.KEEP,
        (7, 1): Verdict.MISSING,
        (7, 2): Verdict.DELETE,
        (7, 3): Verdict.DELETE,
        (8, 0): Verdict.DELETE,
    }
    assert {take: mask.tolist() for take, mask in judged(marks, said).items()} == {
        7: [False, False, True]
    }
    assert marks[7].tolist() == [True, True, False]


def test_a_pair_left_out_by_hand_is_said_to_be_deleted_until_that_is_undone(
    store: Store, takes: tuple[int, list[int]]
) -> None:
    session, (first, second) = takes
    mark_by_hand(store, first, 4, True, 2.0)
    mark_by_hand(store, second, 5, True, 3.0)
    assert store.verdicts(session) == {(first, 4): Verdict.DELETE, (second, 5): Verdict.DELETE}
    assert store.undo_cleaning(session)
    assert store.verdicts(session) == {(first, 4): Verdict.DELETE}
    assert np.flatnonzero(store.marks(session)[first]).tolist() == [4]
    assert not store.marks(session)[second].any()
