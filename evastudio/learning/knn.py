"""Continuous k-nearest neighbour: the mean action of the most similar pairs (paper 3.2)."""

from __future__ import annotations

from evastudio.learning.neighbor_learner import Averaged, Continuous


class KNNPolicy(Continuous, Averaged):
    """Mean action of the `k` nearest pairs by standardised state.

    Search is exact and Euclidean; of pairs equally far, the one recorded first counts first.

    Parameters
    ----------
    k : int
        How many pairs a decision is made from. The paper used 2 to 7.
    weights : {"uniform", "distance"}
        Whether all k count the same, or each by one over its distance (a pair at distance zero
        then decides alone).

    Attributes
    ----------
    states_ : ndarray of shape (n_pairs, n_states), standardised
    actions_ : ndarray of shape (n_pairs, n_actions)
    offset_, scale_ : ndarray of shape (n_states,), the standardisation

    Raises InvalidInputError for no pairs, NaN, wrong shapes, and `k` above the number of pairs.
    """

    def __init__(self, k: int = 5, weights: str = "uniform") -> None:
        self.k = k
        self.weights = weights

    decide = Averaged.average
