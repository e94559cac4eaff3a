"""Studies of people are read as they were kept."""

from __future__ import annotations

import pytest

from evastudio.demonstrations.store import Store
from evastudio.errors import InvalidInputError
from evastudio.evaluation.studies import Study, save_study, studies


def test_studies_are_read_in_the_order_they_were_kept(store: Store) -> None:
    told = [
        Study("asteroids", "nobody, a test", 180.0, 570.0, "asteroids-careful"),
        Study("crowd", "nobody, a test", None, 720.0),
    ]
    assert studies(store) == []
    assert [save_study(store, one, 5.0) for one in told] == [1, 2]
    assert studies(store) == told


def test_times_that_cannot_be_are_refused() -> None:
    with pytest.raises(InvalidInputError, match="demonstrated_s"):
        Study("asteroids", "nobody, a test", None, -1.0)
    with pytest.raises(InvalidInputError, match="instructed_s"):
        Study("asteroids", "nobody, a test", float("nan"), 1.0)
