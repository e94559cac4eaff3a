"""Cleaning a session: which pairs are conflicts, shown before anything is left out."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from evastudio.demonstrations.pairs import Pairs
from evastudio.errors import InvalidInputError
from evastudio.learning.conflicts import ConflictEliminator
from evastudio.world.scene import Scene
from evastudio.world.spaces import Array

Progress = Callable[[float, str], None]
"""Told the share done, 0 to 1, and what is being done."""

N_NEIGHBORS = 9
"""The paper's 5 is out-voted by bursts of mistakes, which lie together in state."""
THRESHOLD = 0.4
"""The paper's l = 5 and 0.1 cut 47 % of the scripted human-like pilot's pairs and 93 % of its
strong turns, and k-NN then crossed 82 to 88 % of the fields, not 97; 9 and 0.4 cut 3 % and cost
nothing (demonstration sets 1 and 2, 200 fields)."""


def silent(share: float, doing: str) -> None:
    """A `Progress` that tells nobody."""


@dataclass(frozen=True)
class Cleaning:
    """What conflict elimination found in some pairs. It leaves nothing out by itself."""

    conflicts: NDArray[np.bool_]
    """Which pairs conflict with their neighbours, shape (pairs,)."""
    deviations: Array
    """Distance of each action from its neighbours' median, as a share of the range, (pairs,)."""
    n_neighbors: int
    threshold: float
    """Deviation beyond which a pair is a conflict, as a share of the range."""
    eta: tuple[float, ...]
    """The same in units of each component of the action."""

    def apply(self, pairs: Pairs) -> Pairs:
        """`pairs` without the conflicts.

        Raises InvalidInputError where these are not the pairs that were looked at.
        """
        if len(pairs) != len(self.conflicts):
            raise InvalidInputError(
                f"The cleaning looked at {len(self.conflicts)} pairs, and now there are "
                f"{len(pairs)}. Clean again."
            )
        return pairs.keep(~self.conflicts)

    def report(self) -> dict[str, Any]:
        """The figures, as JSON holds them."""
        found = int(self.conflicts.sum())
        return {
            "pairs": len(self.conflicts),
            "conflicts": found,
            "kept": len(self.conflicts) - found,
            "share": found / len(self.conflicts),
            "n_neighbors": self.n_neighbors,
            "threshold": self.threshold,
            "eta": list(self.eta),
        }


def clean_pairs(
    pairs: Pairs,
    scene: Scene,
    *,
    n_neighbors: int = N_NEIGHBORS,
    threshold: float | str = THRESHOLD,
    progress: Progress = silent,
) -> Cleaning:
    """Find the conflicts among `pairs` of `scene`; see `ConflictEliminator`.

    Raises InvalidInputError where there are too few pairs or they are not finite.
    """
    if len(pairs) == 0:
        raise InvalidInputError("There are no pairs to clean. Record a take first.")
    if len(pairs) <= n_neighbors:
        raise InvalidInputError(
            f"Cleaning compares every pair with its {n_neighbors} nearest others, and there are "
            f"only {len(pairs)} pairs. Record more first."
        )
    progress(0.0, "Looking for conflicts")
    span = scene.action.high - scene.action.low
    eliminator = ConflictEliminator(
        n_neighbors, threshold, span if np.isfinite(span).all() else None
    )
    eliminator.fit(pairs.states, pairs.actions)
    progress(1.0, "Conflicts found")
    return Cleaning(
        conflicts=eliminator.conflict_mask_,
        deviations=eliminator.deviations_,
        n_neighbors=n_neighbors,
        threshold=eliminator.threshold_,
        eta=tuple(float(part) for part in eliminator.threshold_ * eliminator.range_),
    )
