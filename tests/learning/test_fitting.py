"""Fitting: what it refuses, what it tells meanwhile, and what changes a fingerprint."""

import json

import numpy as np
import pytest

from evastudio.errors import InvalidInputError, NotFoundError
from evastudio.learning.cleaning import clean_pairs
from evastudio.learning.fitting import fit_policy
from evastudio.learning.policy import fingerprint
from tests.learning.fitted import some_pairs


def test_the_fingerprint_changes_with_the_pairs(asteroids):
    pairs = some_pairs(asteroids())
    kept = pairs.keep(np.arange(len(pairs)) != 3)
    assert fingerprint(pairs) == fingerprint(some_pairs(asteroids()))
    assert fingerprint(pairs) != fingerprint(kept)


def test_fitting_refuses_what_it_cannot_use(asteroids):
    scene = asteroids()
    pairs = some_pairs(scene)
    with pytest.raises(NotFoundError, match="Did you mean 'svr'"):
        fit_policy(pairs, scene, "canonical", "svm")
    with pytest.raises(NotFoundError, match="Did you mean 'canonical'"):
        fit_policy(pairs, scene, "canonicle")
    with pytest.raises(NotFoundError, match="no setting 'k' of learner 'svr'"):
        fit_policy(pairs, scene, "canonical", "svr", {"k": 3})
    with pytest.raises(InvalidInputError, match="no pairs"):
        fit_policy(pairs.keep(np.zeros(60, dtype=bool)), scene)
    with pytest.raises(InvalidInputError, match="expected \\(rows, 8\\)"):
        fit_policy(pairs, scene, "paper")
    with pytest.raises(InvalidInputError, match="looked at 60 pairs"):
        fit_policy(pairs.keep(np.arange(60) < 50), scene, cleaning=clean_pairs(pairs, scene))
    with pytest.raises(InvalidInputError, match="only 60"):
        fit_policy(pairs, scene, learner="knn", settings={"k": 61})


def test_too_few_pairs_to_clean_are_refused_in_plain_words(asteroids):
    scene = asteroids()
    for count, says in (
        (0, "no pairs to clean"),
        (
            40,
            "its 25 nearest others from other moments, which needs 44 pairs, and there are only 40",
        ),
    ):
        with pytest.raises(InvalidInputError, match=says):
            clean_pairs(some_pairs(scene).keep(np.arange(60) < count), scene)


def test_fitting_and_cleaning_tell_their_progress(asteroids):
    told = []
    scene = asteroids()
    cleaning = clean_pairs(some_pairs(scene), scene, progress=lambda *news: told.append(news))
    fit_policy(some_pairs(scene), scene, progress=lambda *news: told.append(news))
    shares = [share for share, _ in told]
    assert shares == [0.0, 1.0, 0.0, 0.5, 1.0, 1.0]
    assert cleaning.report()["kept"] + cleaning.report()["conflicts"] == 60
    assert json.dumps(cleaning.report())
