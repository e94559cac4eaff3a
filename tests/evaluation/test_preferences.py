"""Ballots and votes, kept in either database."""

from __future__ import annotations

import pytest

from evastudio.demonstrations.store import Store
from evastudio.errors import ConflictError, InvalidInputError, NotFoundError
from evastudio.evaluation.interval import wilson_interval
from evastudio.evaluation.preferences import (
    Ballot,
    ballots,
    delete_ballot,
    find_ballot,
    open_ballot,
    preference,
    preferences,
    vote,
    votes_of,
)

SCENE = {"name": "asteroids", "version": 3, "options": {"density": 1.0}}


def opened(store: Store) -> Ballot:
    return open_ballot(store, SCENE, {"mine": "ab12", "straight": None}, 7, 5.0)


def test_a_ballot_is_read_as_it_was_opened(store: Store) -> None:
    one, two = opened(store), opened(store)
    assert find_ballot(store, one.id) == one
    assert (one.pilots, one.seed, one.scene_version) == ({"mine": "ab12", "straight": None}, 7, 3)
    assert one.secret != two.secret
    assert [ballot.id for ballot in ballots(store)] == [two.id, one.id]
    assert [ballot.id for ballot in ballots(store, after=two.id, limit=1)] == [one.id]
    assert ballots(store, "crowd") == []
    with pytest.raises(InvalidInputError, match="between two"):
        open_ballot(store, SCENE, {"mine": None}, 7, 5.0)


def test_votes_come_to_a_share_with_its_interval(store: Store) -> None:
    ballot = opened(store)
    assert preference(store, ballot).says == "Nobody has preferred one of them yet."
    assert preferences(store) == []
    for voter, found in {"Vera": [1, 1, None], "Rolf": [1, 0], "": [1]}.items():
        for number, chosen in enumerate(found):
            assert votes_of(store, ballot.id, voter) == number
            vote(store, ballot, voter, number, chosen, 6.0)
    came = preference(store, ballot)
    assert (came.votes, came.neither, came.people) == ((1, 4), 1, 3)
    assert (came.share, came.interval) == (0.8, wilson_interval(4, 5))
    assert came.says.startswith("straight looked livelier than mine in 4 of 5 votes: 80 % (38 to")
    assert came.says.endswith("That can still be chance.")
    assert preferences(store) == [came]
    with pytest.raises(ConflictError, match="already"):
        vote(store, ballot, "Vera", 2, 0, 6.0)
    delete_ballot(store, ballot.id)
    assert preferences(store) == []
    with pytest.raises(NotFoundError, match="no ballot"):
        find_ballot(store, ballot.id)


def test_who_stands_left_is_drawn_anew_for_each_and_does_not_change(store: Store) -> None:
    one, two = opened(store), opened(store)
    orders = [one.order("Vera", number) for number in range(400)]
    assert orders == [one.order("Vera", number) for number in range(400)]
    assert {(0, 1), (1, 0)} == set(orders)
    share = sum(left for left, _ in orders) / 400
    assert 0.4 < share < 0.6
    for other in (
        [one.order("Rolf", n) for n in range(400)],
        [two.order("Vera", n) for n in range(400)],
    ):
        alike = sum(a == b for a, b in zip(orders, other, strict=True)) / 400
        assert 0.4 < alike < 0.6
