"""Studies of people are read as they were kept."""

from __future__ import annotations

import pytest

from evastudio.demonstrations.store import Store
from evastudio.errors import InvalidInputError, NotFoundError
from evastudio.evaluation.studies import (
    Study,
    find_study,
    forget_study,
    replace_study,
    save_study,
    studies,
    study_records,
)


def test_studies_are_read_in_the_order_they_were_kept(store: Store) -> None:
    told = [
        Study("asteroids", "nobody, a test", 180.0, 570.0, "asteroids-careful"),
        Study("crowd", "nobody, a test", None, 720.0),
    ]
    assert studies(store) == []
    assert [save_study(store, one, 5.0) for one in told] == [1, 2]
    assert studies(store) == told


def test_a_study_is_replaced_as_somebody_goes_on_and_forgotten_as_they_wish(store: Store) -> None:
    first = save_study(store, Study("asteroids", "artist", 90.0, 40.0), 5.0)
    other = save_study(store, Study("crowd", "designer", 60.0, 70.0), 6.0)
    replace_study(store, first, Study("asteroids", "artist", 90.0, 200.0))
    kept = find_study(store, first)
    assert (kept.demonstrated_s, kept.created_at) == (200.0, 5.0)
    assert [one.id for one in study_records(store, after=first)] == [other]
    forget_study(store, first)
    assert [one.person for one in studies(store)] == ["designer"]
    for missing in (find_study, forget_study):
        with pytest.raises(NotFoundError, match="no study"):
            missing(store, first)
    with pytest.raises(NotFoundError, match="no study"):
        replace_study(store, first, Study("asteroids", "artist", 90.0, 1.0))


def test_times_that_cannot_be_are_refused() -> None:
    with pytest.raises(InvalidInputError, match="demonstrated_s"):
        Study("asteroids", "nobody, a test", None, -1.0)
    with pytest.raises(InvalidInputError, match="instructed_s"):
        Study("asteroids", "nobody, a test", float("nan"), 1.0)
