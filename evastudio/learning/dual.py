"""The dual problem of epsilon-SVR with a Gaussian kernel, solved for several outputs at once.

Of each output: minimise 1/2 beta'K beta - y'beta + epsilon |beta|_1 over -C <= beta <= C with
sum(beta) = 0. Two solvers stand behind one function: compiled SMO (`kernels.smo`), and
scikit-learn's SVR, which a test holds against it.
"""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.distance import cdist
from sklearn.exceptions import ConvergenceWarning

from evastudio.world.spaces import Array

TOLERANCE = 1e-3
"""Violation of optimality at which to stop, as scikit-learn's default."""
BLOCK = 512
"""Points whose kernel rows are computed at a time to measure a solution."""
SHARE_OF_WHOLE = 0.7
"""Share of the memory for rows over all pairs; the rest is for the shorter ones of shrinking."""


@dataclass(frozen=True)
class DualSolution:
    """Where the dual of each output has its minimum."""

    weights: Array
    """beta, shape (pairs, outputs), in [-C, C]; zero for pairs that are no support vectors."""
    intercepts: Array
    """What is added to the sum of kernels, shape (outputs,)."""
    objectives: Array
    """The dual objective reached, shape (outputs,)."""
    violations: Array
    """Largest violation of optimality left, shape (outputs,); at most the tolerance."""
    steps: NDArray[np.int64]
    """Steps of SMO taken, shape (outputs,)."""


def solve_dual(
    points: Array,
    targets: Array,
    *,
    C: float,  # noqa: N803 - the literature's name
    epsilon: float,
    gamma: float,
    tolerance: float = TOLERANCE,
    megabytes: float = 400.0,
    start: Array | None = None,
    watch: Callable[[float], None] | None = None,
    plain: bool = False,
) -> DualSolution:
    """Solve for `points` (pairs, n) and `targets` (pairs, outputs), both of size about 1.

    `start` (pairs, outputs) are weights to begin with, those of a nearby C, epsilon or gamma;
    they are scaled into the box. Kernel rows take up to about `megabytes`; those that do not
    fit are computed again when needed. `watch` hears the share done, from 0 to 1, about every
    hundredth of a second, and may raise to stop. `plain` asks scikit-learn instead, which knows
    neither `start` nor `watch`. Warns with ConvergenceWarning where it gives up.
    """
    if plain:
        solution = _plain(points, targets, C, epsilon, gamma, tolerance, megabytes)
    else:
        solution = _compiled(points, targets, C, epsilon, gamma, tolerance, megabytes, start, watch)
    if (solution.violations > 2.0 * tolerance).any():
        warnings.warn(
            f"The support vector machine stopped {solution.violations.max():.2g} from the best "
            f"fit, asked for {tolerance:g}. Choose a smaller C or a larger epsilon.",
            ConvergenceWarning,
            stacklevel=3,
        )
    return solution


def _compiled(
    points: Array,
    targets: Array,
    C: float,  # noqa: N803
    epsilon: float,
    gamma: float,
    tolerance: float,
    megabytes: float,
    start: Array | None,
    watch: Callable[[float], None] | None,
) -> DualSolution:
    from evastudio.learning.kernels.smo import (
        Descent,
        Rows,
        memory_for,
        minimise,
    )  # numba loads slowly

    count, outputs = targets.shape
    # float32 resolves distances best around the middle.
    centred = (points - points.mean(axis=0)).astype(np.float32)
    rows = Rows(centred, gamma, memory_for(count, SHARE_OF_WHOLE * megabytes))
    spare = memory_for(count, megabytes - rows.rows.nbytes / 1e6)
    weights = np.zeros((count, outputs))
    intercepts, objectives, violations = (np.empty(outputs) for _ in range(3))
    steps = np.empty(outputs, np.int64)
    for output in range(outputs):
        beta = np.zeros(count) if start is None else _into_box(start[:, output], C)
        descent = Descent(rows, np.ascontiguousarray(targets[:, output]), beta, C, epsilon)
        first = max(float(np.subtract(*descent.range())), 2.0 * tolerance)

        def report(violation: float, done: int = output, first: float = first) -> None:
            if watch is not None:
                left = math.log(max(violation, tolerance) / tolerance)
                share = min(1.0, max(0.0, 1.0 - left / math.log(first / tolerance)))
                watch((done + share) / outputs)

        most = most_steps(count)
        steps[output], violations[output] = minimise(descent, tolerance, most, spare, report)
        weights[:, output] = descent.beta
        slopes = descent.slopes[:count]
        intercepts[output] = _intercept(slopes, descent.beta, C, epsilon, descent.range())
        objectives[output] = _objective(slopes, targets[:, output], descent.beta, epsilon)
    return DualSolution(weights, intercepts, objectives, violations, steps)


def most_steps(pairs: int) -> int:
    """Steps for one output after which to give up; as LIBSVM."""
    return max(10_000_000, 100 * pairs)


def _plain(
    points: Array,
    targets: Array,
    C: float,  # noqa: N803
    epsilon: float,
    gamma: float,
    tolerance: float,
    megabytes: float,
) -> DualSolution:
    count, outputs = targets.shape
    weights = np.zeros((count, outputs))
    intercepts, objectives, violations = (np.empty(outputs) for _ in range(3))
    steps = np.empty(outputs, np.int64)
    from sklearn.svm import SVR  # brings half of scikit-learn, and is seldom needed

    for output in range(outputs):
        machine = SVR(C=C, epsilon=epsilon, gamma=gamma, tol=tolerance, cache_size=megabytes)
        machine.fit(points, targets[:, output])
        beta = weights[:, output]
        beta[machine.support_] = machine.dual_coef_[0]
        intercepts[output], steps[output] = machine.intercept_[0], machine.n_iter_
        slopes = dual_slopes(points, targets[:, output], beta, gamma)
        objectives[output] = _objective(slopes, targets[:, output], beta, epsilon)
        violations[output] = dual_violation(slopes, beta, C, epsilon)
    return DualSolution(weights, intercepts, objectives, violations, steps)


def dual_slopes(points: Array, targets: Array, beta: Array, gamma: float) -> Array:
    """targets - K beta, in float64, shape (pairs,)."""
    support = np.flatnonzero(beta)
    slopes = targets.astype(np.float64)
    for start in range(0, len(points), BLOCK):
        rows = slice(start, start + BLOCK)
        apart = cdist(points[rows], points[support], "sqeuclidean")
        slopes[rows] -= np.exp(-gamma * apart) @ beta[support]
    return slopes


def dual_violation(
    slopes: Array,
    beta: Array,
    C: float,  # noqa: N803
    epsilon: float,
) -> float:
    """How steeply the objective falls along the best pair of variables; 0 or less at the end."""
    rise = np.where(beta >= 0.0, epsilon, -epsilon)
    fall = np.where(beta > 0.0, epsilon, -epsilon)
    top = np.where(beta >= C, -np.inf, slopes - rise).max()
    bottom = np.where(beta <= -C, np.inf, slopes - fall).min()
    return float(top - bottom)


def _objective(slopes: Array, targets: Array, beta: Array, epsilon: float) -> float:
    return float(epsilon * np.abs(beta).sum() - 0.5 * beta @ (targets + slopes))


def _intercept(
    slopes: Array,
    beta: Array,
    C: float,  # noqa: N803
    epsilon: float,
    ends: tuple[float, float],
) -> float:
    """The mean over the free support vectors, else the middle of what is possible (as LIBSVM)."""
    free = (beta != 0.0) & (np.abs(beta) < C)
    if free.any():
        return float((slopes[free] - epsilon * np.sign(beta[free])).mean())
    return float(sum(ends) / 2.0)


def _into_box(start: Array, C: float) -> Array:  # noqa: N803
    """`start`, scaled so that none is beyond C; the sum stays zero."""
    largest = float(np.abs(start).max(initial=0.0))
    return np.array(start * (C / largest) if largest > C else start, dtype=np.float64)
