"""A support vector machine with few bases, refitted to answer as the whole one does."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solve_triangular
from scipy.spatial.distance import cdist

from evastudio.world.spaces import Array

RIDGE = 1e-9
"""Penalty on squared weights, for each state: keeps them small where bases nearly coincide."""
LEAST = 1e-9
"""A state within this of what the bases span already (squared, of 1) adds nothing."""
ROWS = 50_000
"""States at most to choose from and to fit: more would cost memory and change little."""


@dataclass(frozen=True)
class CompactForm:
    """A sum of Gaussian bumps of limited size."""

    chosen: NDArray[np.int64]
    """Which states became bases, shape (bases,)."""
    vectors: Array
    """The bases, shape (bases, n): their states rounded to float16, as they are stored."""
    weights: Array
    """Shape (bases, m), rounded to float32, as they are stored."""
    intercept: Array
    """Shape (m,)."""


def compact_form(states: Array, answers: Array, gamma: float, bases: int) -> CompactForm:
    """At most `bases` bumps that give nearly `answers` (rows, m) at `states` (rows, n).

    `states` are standardised. The weights come from least squares with a little ridge, after the
    bases are rounded, so that the rounding costs nothing.
    """
    picked = np.arange(len(states))
    if len(states) > ROWS:
        picked = np.linspace(0, len(states) - 1, ROWS).astype(np.int64)
        states, answers = states[picked], answers[picked]
    chosen = choose_bases(states, gamma, bases)
    vectors = states[chosen].astype(np.float16).astype(np.float64)
    kernel = np.exp(-gamma * cdist(states, vectors, "sqeuclidean"))
    middle = answers.mean(axis=0)
    # The ridge as more rows: by QR the condition is not squared as by the normal equations.
    columns = np.hstack([kernel, np.ones((len(states), 1))])
    penalty = np.sqrt(RIDGE * len(states)) * np.eye(len(chosen), len(chosen) + 1)
    wanted = np.vstack([answers - middle, np.zeros((len(chosen), answers.shape[1]))])
    orthogonal, triangle = np.linalg.qr(np.vstack([columns, penalty]))
    solution = solve_triangular(triangle, orthogonal.T @ wanted)
    weights = solution[:-1].astype(np.float32).astype(np.float64)
    return CompactForm(picked[chosen], vectors, weights, solution[-1] + middle)


def choose_bases(states: Array, gamma: float, bases: int) -> NDArray[np.int64]:
    """At most `bases` of `states`, each time the one that the bumps so far describe worst.

    Greedy pivoted Cholesky decomposition of the kernel matrix (Fine and Scheinberg, Efficient
    SVM Training Using Low-Rank Kernel Representations, JMLR 2, 2001). Of states described equally
    badly the first is taken. Stops early where nothing is left to describe.
    """
    count = len(states)
    factor = np.empty((min(bases, count), count))
    left = np.ones(count)
    chosen: list[int] = []
    for rank in range(len(factor)):
        pivot = int(left.argmax())
        if left[pivot] <= LEAST and chosen:
            break
        apart = cdist(states[pivot : pivot + 1], states, "sqeuclidean")[0]
        column = np.exp(-gamma * apart) - factor[:rank, pivot] @ factor[:rank]
        factor[rank] = column / np.sqrt(left[pivot])
        left -= factor[rank] ** 2
        left[pivot] = 0.0
        chosen.append(pivot)
    return np.array(chosen, dtype=np.int64)
