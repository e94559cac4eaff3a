"""What others do about conflicts, to compare with: quantise by clustering, or blend them."""

from __future__ import annotations

from typing import Any, Self

import numpy as np
from sklearn.base import BaseEstimator
from sklearn.cluster import MiniBatchKMeans

from evastudio.errors import InvalidInputError
from evastudio.learning.checking import checked_pairs, positive
from evastudio.learning.neighbors import NeighborIndex
from evastudio.learning.scaling import Scaling

PER_CLUSTER = 20
"""Pairs to a cluster where the number of clusters is left open."""


class ClusterEliminator(BaseEstimator):  # type: ignore[misc]
    """Keeps of each cluster of pairs with like states those whose actions are of the main kind.

    After Friedrich et al. 1996, whom the paper names (section 2): states are quantised, and in each
    quantum one action stands. States are parted by k-means; the actions of a part are parted in two
    halfway along the line on which they differ most, and where the means of the two are farther
    apart than `threshold` only the larger stays.

    Parameters
    ----------
    n_clusters : int or None
        Parts of the states; one for every 20 pairs where None.
    threshold : float
        Distance between the two kinds of action, as a share of their range, from which on the
        smaller is a conflict.
    random_state : int
        Seed of the clustering.

    Attributes as `ConflictEliminator`: sample_indices_, conflict_mask_.

    Raises InvalidInputError for NaN, wrong shapes, and more clusters than pairs.
    """

    def __init__(
        self, n_clusters: int | None = None, threshold: float = 0.1, random_state: int = 0
    ) -> None:
        self.n_clusters = n_clusters
        self.threshold = threshold
        self.random_state = random_state

    def fit(self, states: Any, actions: Any = None) -> Self:
        """Find the conflicts among states (pairs, n) and actions (pairs, m) or (pairs,)."""
        positive(self, threshold=self.threshold)
        states, actions = checked_pairs(self, states, actions)
        count = self.n_clusters or max(1, len(states) // PER_CLUSTER)
        if not 1 <= count <= len(states):
            raise InvalidInputError(
                f"{count} clusters were asked for, but there are {len(states)} pairs; choose from "
                f"1 to {len(states)}."
            )
        span = np.ptp(actions, axis=0)
        shares = actions / np.where(span > 0, span, 1.0)
        parts = self._parted(Scaling.of(states).apply(states), count)
        self.conflict_mask_ = np.zeros(len(states), dtype=bool)
        for part in np.unique(parts):
            rows = np.flatnonzero(parts == part)
            # The two kinds: apart along the line on which the actions of this part differ most.
            away = shares[rows] - shares[rows].mean(axis=0)
            along = away @ np.linalg.svd(away, full_matrices=False)[2][0]
            upper = along > (along.min() + along.max()) / 2
            if not upper.any() or upper.all():
                continue
            apart = shares[rows[upper]].mean(axis=0) - shares[rows[~upper]].mean(axis=0)
            if np.linalg.norm(apart) > self.threshold:
                self.conflict_mask_[rows[upper == (2 * upper.sum() <= len(rows))]] = True
        self.sample_indices_ = np.flatnonzero(~self.conflict_mask_)
        return self

    def fit_resample(self, states: Any, actions: Any) -> tuple[Any, Any]:
        """The states and actions without the conflicts, in their order."""
        self.fit(states, actions)
        return np.asarray(states)[self.sample_indices_], np.asarray(actions)[self.sample_indices_]

    def _parted(self, points: Any, count: int) -> Any:
        means = MiniBatchKMeans(count, random_state=self.random_state, n_init=1, batch_size=4096)
        return means.fit_predict(points)


class ConflictBlender(BaseEstimator):  # type: ignore[misc]
    """Leaves no pair out; gives each the mean action of itself and its nearest others.

    What learners that average do anyway, and what the paper warns of (section 3.1): the mean of
    two ways round an obstacle leads into it.

    Parameters
    ----------
    n_neighbors : int
        How many others are blended in.

    Attributes as `ConflictEliminator`: sample_indices_ (all), conflict_mask_ (none).

    Raises InvalidInputError for NaN, wrong shapes, and no more than `n_neighbors` pairs.
    """

    def __init__(self, n_neighbors: int = 5) -> None:
        self.n_neighbors = n_neighbors

    def fit(self, states: Any, actions: Any = None) -> Self:
        """Blend the actions (pairs, m) or (pairs,) of like states (pairs, n)."""
        positive(self, n_neighbors=self.n_neighbors)
        states, actions = checked_pairs(self, states, actions)
        index = NeighborIndex(Scaling.of(states).apply(states))
        neighbors = index.nearest_others(int(self.n_neighbors))
        total = actions + actions[neighbors].sum(axis=1)
        blended = total / (1 + int(self.n_neighbors))
        self.actions_ = blended[:, 0] if self.flat_ else blended
        self.sample_indices_ = np.arange(len(states))
        self.conflict_mask_ = np.zeros(len(states), dtype=bool)
        return self

    def fit_resample(self, states: Any, actions: Any) -> tuple[Any, Any]:
        """The states as they are and the blended actions."""
        self.fit(states, actions)
        return np.asarray(states), self.actions_
