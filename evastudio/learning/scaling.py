"""Standardisation: every state component gets mean 0 and spread 1 before distances are taken."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from evastudio.world.spaces import Array


@dataclass(frozen=True)
class Scaling:
    """An affine map of each component, fitted once and stored with the policy."""

    offset: Array
    """Mean of each component, shape (n,)."""
    scale: Array
    """Standard deviation of each component, shape (n,); 1 where a component never changes."""

    @staticmethod
    def of(values: Array) -> Scaling:
        """The standardisation of `values` (rows, n)."""
        offset = values.mean(axis=0)
        spread = values.std(axis=0)
        # Rounding leaves a constant column a spread of about 1e-16 of its size, not zero.
        flat = spread <= 1e-12 * np.maximum(np.abs(offset), 1.0)
        return Scaling(offset, np.where(flat, 1.0, spread))

    def apply(self, values: Array) -> Array:
        """`values` (rows, n), standardised."""
        return (values - self.offset) / self.scale
