"""The moments of a run are kept in blocks and come out as they went in."""

from __future__ import annotations

import numpy as np
import pytest

from evastudio.live import moments as blocks
from evastudio.live.moments import Moments
from evastudio.world.snapshot import AnyArray, Snapshot

FIXED = {"rocks": np.arange(12.0).reshape(1, 4, 3)}


def moment(step: int, place: AnyArray | None = None) -> Snapshot:
    where = np.full((1, 3), step / 7) if place is None else place
    return Snapshot(FIXED, {"steps": np.array([step]), "place": where})


def same(one: Snapshot, other: Snapshot) -> bool:
    return one.fixed is other.fixed and all(
        one[name].dtype == other[name].dtype and np.array_equal(one[name], other[name])
        for name in one.moving
    )


def test_each_comes_out_as_it_went_in() -> None:
    kept, given = Moments(), [moment(step) for step in range(1000)]
    for one in given:
        kept.append(one)
    assert len(kept) == 1000
    assert all(same(one, other) for one, other in zip(kept, given, strict=True))
    assert same(kept[-1], given[-1])
    assert [int(one["steps"][0]) for one in kept[10:40:7]] == [10, 17, 24, 31, 38]
    assert kept.bytes == 1000 * 32
    with pytest.raises(IndexError):
        kept[1000]


def test_arrays_that_become_others_are_kept_as_they_are() -> None:
    places = [
        np.zeros((1, 3), dtype=np.int64),
        np.full((1, 3), 0.7),
        np.full((1, 2), 0.7),
        np.array([["far off"]]),
        np.array([["here"]]),
        np.zeros((1, 0)),
    ]
    kept, given = Moments(), [moment(step, place) for step, place in enumerate(3 * places)]
    for one in given:
        kept.append(one)
    assert all(same(one, other) for one, other in zip(kept, given, strict=True))
    assert kept.bytes == sum(one["steps"].nbytes + one["place"].nbytes for one in given)


def test_the_oldest_are_forgotten_block_by_block(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(blocks, "BLOCK", 4)
    kept = Moments()
    for step in range(11):
        kept.append(moment(step))
    assert list(kept.forget()) == [0, 1, 2, 3]
    assert list(kept.forget()) == [4, 5, 6, 7]
    assert list(kept.forget()) == [], "the latest stay"
    assert (kept.first, len(kept), kept.bytes) == (8, 3, 3 * 32)
    kept.append(moment(11))
    assert [int(one["steps"][0]) for one in kept] == [8, 9, 10, 11]


def test_what_was_asked_for_stays_while_the_run_goes_on(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(blocks, "BLOCK", 4)
    kept = Moments()
    for step in range(6):
        kept.append(moment(step))
    asked = kept.as_they_are()
    for step in range(6, 20):
        kept.append(moment(step))
        kept.forget()
    assert [int(one["steps"][0]) for one in asked] == list(range(6))


def test_a_moment_larger_than_a_block_is_one(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(blocks, "BLOCK_BYTES", 1)
    kept = Moments()
    for step in range(3):
        kept.append(moment(step))
    assert list(kept.forget()) == [0]
