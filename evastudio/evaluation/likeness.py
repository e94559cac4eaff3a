"""How alike two ways of moving are: distances between distributions of what was done."""

from __future__ import annotations

import numpy as np
from scipy.spatial.distance import cdist

from evastudio.errors import InvalidInputError
from evastudio.world.spaces import Array

MOST = 1500
"""No more moments of either side are compared; of more, evenly spaced ones."""


def inhomogeneity(ours: Array, theirs: Array) -> float:
    """The energy distance of two samples, from 0 for the same distribution to 1.

    ours, theirs: shape (moments, d); every component is first divided by its spread in `theirs`.
    The coefficient H of G. J. Szekely, M. L. Rizzo, "Energy statistics: a class of statistics
    based on distances", J. Stat. Plan. Inference 143, 2013, section 3. Samples of one
    distribution do not come out at zero exactly; compare the demonstrator with itself to know how
    much chance gives. Raises InvalidInputError for no moments and for different widths.
    """
    if min(len(ours), len(theirs)) == 0 or ours.shape[1:] != theirs.shape[1:]:
        raise InvalidInputError(
            f"Samples of shapes {ours.shape} and {theirs.shape} cannot be compared; both need "
            "moments, and the same components."
        )
    spread = theirs.std(axis=0)
    spread = np.where(spread > 0.0, spread, 1.0)
    first, second = thinned(ours) / spread, thinned(theirs) / spread
    between = float(cdist(first, second).mean())
    within = float(cdist(first, first).mean()) + float(cdist(second, second).mean())
    return 0.0 if between == 0.0 else max(0.0, (2.0 * between - within) / (2.0 * between))


def thinned(moments: Array, most: int = MOST) -> Array:
    """At most `most` evenly spaced rows of `moments`."""
    if len(moments) <= most:
        return moments
    return moments[np.linspace(0, len(moments) - 1, most).round().astype(np.int64)]
