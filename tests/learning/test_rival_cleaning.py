"""What others do about conflicts: clustering and blending, on cases with known answers."""

import numpy as np
import pytest

from evastudio.errors import InvalidInputError
from evastudio.learning.rival_cleaning import ClusterEliminator, ConflictBlender


def test_in_each_cluster_the_main_kind_of_action_stays():
    rng = np.random.default_rng(0)
    states = np.repeat([[0.0], [10.0]], 30, axis=0) + rng.normal(scale=0.1, size=(60, 1))
    actions = np.repeat([0.0, 1.0], 30)
    actions[[3, 4]], actions[40] = 1.0, 0.0
    learner = ClusterEliminator(2, 0.5)
    kept_states, kept_actions = learner.fit_resample(states, actions)
    assert np.flatnonzero(learner.conflict_mask_).tolist() == [3, 4, 40]
    assert len(kept_states) == len(kept_actions) == 57


def test_clusters_in_agreement_lose_nothing():
    states = np.linspace(0, 1, 50)[:, None]
    assert not ClusterEliminator(threshold=0.5).fit(states, states).conflict_mask_.any()


def test_blending_leaves_no_pair_out_and_evens_the_actions():
    states = np.arange(6.0)[:, None]
    actions = np.array([0.0, 0.0, 3.0, 0.0, 0.0, 0.0])
    same, blended = ConflictBlender(2).fit_resample(states, actions)
    assert np.array_equal(same, states)
    assert blended.tolist() == [1.0, 1.0, 1.0, 1.0, 0.0, 0.0]


def test_bad_settings_are_named():
    with pytest.raises(InvalidInputError, match="9 clusters"):
        ClusterEliminator(9).fit(np.zeros((5, 1)), np.zeros(5))
    with pytest.raises(InvalidInputError, match="n_neighbors=0"):
        ConflictBlender(0).fit(np.zeros((5, 1)), np.zeros(5))
