"""Ballots by the client."""

from __future__ import annotations

import pytest

from evastudio.client import Studio as Client
from evastudio.errors import ConflictError, NotFoundError


def test_a_vote_is_cast_blind_and_counted(far: Client) -> None:
    two = ("scripted:careful", "straight")
    ballot = far.ballots.open("asteroids", two, options={"density": 2.0}, seed=9)
    assert (ballot.votes, ballot.mine) == (0, 0)
    assert ballot in list(far.ballots.of("asteroids"))
    assert ballot not in list(far.ballots.of("street"))
    shown = far.ballots.show(ballot.id)
    assert [column.title for column in shown.columns] == ["Left", "Right"]
    assert shown.ballot == ballot.id
    cast = far.ballots.vote(ballot.id, shown, "left")
    assert {cast.left, cast.right} == set(two)
    assert cast.livelier == cast.left
    assert sorted(cast.preference.votes) == [0, 1]
    with pytest.raises(ConflictError):
        far.ballots.vote(ballot.id, shown, "right")
    assert far.ballots.preference(ballot.id) == cast.preference
    assert cast.preference in far.ballots.preferences()
    assert f"| asteroids | {cast.livelier} | " in far.ballots.table_three()
    assert far.ballots.get(ballot.id).mine == 1
    far.ballots.delete(ballot.id)
    with pytest.raises(NotFoundError):
        far.ballots.get(ballot.id)
