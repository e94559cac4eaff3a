"""A weighted sum of Gaussian bumps: what a support vector machine decides with."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from importlib.util import find_spec
from typing import Any

import numpy as np
from scipy.spatial.distance import cdist

from evastudio.errors import InvalidInputError
from evastudio.learning.scaling import Scaling
from evastudio.world.spaces import Array

BLOCK = 256
"""Queries answered at a time on the plain path, so that the kernel matrix stays in cache."""


def compiled() -> bool:
    """Whether numba is here to compile the fast path."""
    return find_spec("numba") is not None


class Bumps:
    """Answers sum_i weights[i] exp(-gamma |x - vectors[i]|^2) + intercept, x standardised.

    `vectors` (count, n), `weights` (count, m), `intercept` (m,). A state's answer is bit for bit
    the same alone and in any batch. Threads may share one. `plain` leaves numba aside.
    """

    def __init__(
        self,
        vectors: Array,
        weights: Array,
        gamma: float,
        intercept: Array,
        scaling: Scaling,
        *,
        plain: bool = False,
    ) -> None:
        self.vectors, self.weights = vectors, weights
        self.gamma, self.intercept, self.scaling = gamma, intercept, scaling
        self.size, self.outputs = vectors.shape[1], weights.shape[1]
        self.plain = plain or not compiled()
        self._machine: Array | None = None

    def answer(self, states: Array) -> Array:
        """Answers (rows, m) to raw `states` (rows, n). Raises InvalidInputError for another n."""
        if states.ndim != 2 or states.shape[1] != self.size:
            raise InvalidInputError(
                f"States of shape {states.shape} were given; expected (rows, {self.size})."
            )
        if self.plain:
            return self._plainly(states)
        machine = self._machine
        if machine is None:
            machine = self._machine = _pack()(
                self.vectors,
                self.weights,
                self.gamma,
                self.intercept,
                self.scaling.offset,
                self.scaling.scale,
            )
        answers = np.empty((len(states), self.outputs))
        _decide()(machine, np.ascontiguousarray(states, dtype=np.float64), answers)
        return answers

    def _plainly(self, states: Array) -> Array:
        scaled = self.scaling.apply(states)
        answers = np.empty((len(states), self.outputs))
        columns = np.ascontiguousarray(self.weights.T)
        for start in range(0, len(states), BLOCK):
            rows = slice(start, start + BLOCK)
            kernel = cdist(scaled[rows], self.vectors, "sqeuclidean")
            kernel *= -self.gamma
            np.exp(kernel, out=kernel)
            for column, weights in enumerate(columns):  # BLAS rounds as the batch is large
                answers[rows, column] = (kernel * weights).sum(axis=1)
        return answers + self.intercept


@cache
def _pack() -> Callable[..., Array]:
    from evastudio.learning.kernels.gaussian import pack  # numba loads slowly

    return pack


@cache
def _decide() -> Any:
    from evastudio.learning.kernels.gaussian import decide

    return decide
