"""A weighted sum of Gaussian bumps: what a support vector machine decides with."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.spatial.distance import cdist

from evastudio.errors import InvalidInputError
from evastudio.learning.scaling import Scaling
from evastudio.world.compiled import is_compiled
from evastudio.world.spaces import Array

BLOCK = 256
"""Queries answered at a time on the plain path, so that the kernel matrix stays in cache."""

_KERNEL: list[Any] = []
"""The compiled function, once it is loaded."""


class Bumps:
    """Answers sum_i weights[i] exp(-gamma |x - vectors[i]|^2) + intercept, x standardised.

    `vectors` (count, n), `weights` (count, m), `intercept` (m,). A state's answer is bit for bit
    the same alone and in any batch. Threads may share one. `plain` leaves the compiled path aside;
    None does until the kernels are at hand. Both agree to about 1e-12.
    """

    def __init__(
        self,
        vectors: Array,
        weights: Array,
        gamma: float,
        intercept: Array,
        scaling: Scaling,
        *,
        plain: bool | None = None,
    ) -> None:
        self.vectors, self.weights = vectors, weights
        self.gamma, self.intercept, self.scaling = gamma, intercept, scaling
        self.size, self.outputs = vectors.shape[1], weights.shape[1]
        self.plain = not is_compiled() if plain is None else plain
        self._machine: Array | None = None

    def answer(self, states: Array) -> Array:
        """Answers (rows, m) to raw `states` (rows, n). Raises InvalidInputError for another n."""
        if self._machine is None:
            return self._first(states)
        answers = np.empty((len(states), self.outputs))
        try:
            fits = _KERNEL[0](self._machine, states, answers)
        except TypeError:  # cheaper than looking each time whether the array lies as it should
            states = np.ascontiguousarray(states, dtype=np.float64)
            fits = states.ndim == 2 and _KERNEL[0](self._machine, states, answers)
        if not fits:
            raise self._misfit(states)
        return answers

    def _first(self, states: Array) -> Array:
        """The plain path, or getting ready for the other."""
        if self.plain:
            if states.ndim != 2 or states.shape[1] != self.size:
                raise self._misfit(states)
            return self._plainly(states)
        from evastudio.learning.kernels.gaussian import decide, pack  # numba loads slowly

        _KERNEL[:] = [decide]
        self._machine = pack(
            self.vectors,
            self.weights,
            self.gamma,
            self.intercept,
            self.scaling.offset,
            self.scaling.scale,
        )
        return self.answer(states)

    def _misfit(self, states: Array) -> InvalidInputError:
        return InvalidInputError(
            f"States of shape {states.shape} were given; expected (rows, {self.size})."
        )

    def __getstate__(self) -> dict[str, Any]:
        """Without what `_first` makes: the process it is sent to may not have loaded the kernel."""
        return {**self.__dict__, "_machine": None}

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
