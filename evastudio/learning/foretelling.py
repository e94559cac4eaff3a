"""How well one thing can be foretold from another on takes held out, by a quick smooth curve.

Delay and diagnostics ask this many times over, of pairings that are never used to act; a curve of
the second degree answers in a hundredth of the time of a policy, and closely enough: in a good
frame what is done bends no more.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from evastudio.learning.holdout import Mask
from evastudio.learning.scaling import Scaling
from evastudio.world.spaces import Array

COMPONENTS = 20
"""Of wider givens the principal components up to here count."""
RIDGE = 0.01
"""Weight of the squared slopes, for each pair: little, but few pairs are not followed slavishly."""


def curve_terms(given: Array) -> Array:
    """1, the components of `given` (pairs, n), their squares and products, each at spread 1."""
    flat = Scaling.of(given).apply(given)
    if flat.shape[1] > COMPONENTS:
        _, axes = np.linalg.eigh(flat.T @ flat)
        flat = flat @ axes[:, : -COMPONENTS - 1 : -1]
        flat = Scaling.of(flat).apply(flat)
    first, second = np.triu_indices(flat.shape[1])
    bent = flat[:, first] * flat[:, second]
    bent = Scaling.of(bent).apply(bent)
    return np.concatenate([np.ones((len(flat), 1)), flat, bent], axis=1)


def plane_terms(given: Array) -> Array:
    """1 and the components of `given` (pairs, n), each at spread 1."""
    return np.concatenate([np.ones((len(given), 1)), Scaling.of(given).apply(given)], axis=1)


def foretold(
    given: Array,
    wanted: Array,
    folds: tuple[Mask, ...],
    unit: Array,
    terms_of: Callable[[Array], Array] = curve_terms,
    ridge: float = RIDGE,
) -> Array:
    """Mistakes (pairs,) in telling `wanted` (pairs, m) from `given` (pairs, n).

    Every fold (pairs,) is told by a curve through the pairs of the others, or by what else
    `terms_of` gives. A mistake is the mean over the components of the squared difference in units
    of `unit` (m,).
    """
    terms = terms_of(given)
    scaled = wanted / unit
    grams = [terms[fold].T @ terms[fold] for fold in folds]
    products = [terms[fold].T @ scaled[fold] for fold in folds]
    gram, product = sum(grams), sum(products)
    weight = np.full(terms.shape[1], ridge)
    weight[0] = 0.0  # the constant is free
    wrong = np.empty(len(wanted))
    for fold, own_gram, own_product in zip(folds, grams, products, strict=True):
        taught = gram - own_gram
        slopes = np.linalg.solve(
            taught + np.diag(weight * taught[0, 0] + 1e-9), product - own_product
        )
        wrong[fold] = ((terms[fold] @ slopes - scaled[fold]) ** 2).mean(axis=1)
    return wrong
