"""Cleaning a session: which pairs are conflicts, shown before anything is left out."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from evastudio.demonstrations.pairs import Pairs
from evastudio.errors import InvalidInputError
from evastudio.learning.conflicts import Conflict, ConflictEliminator
from evastudio.world.scene import Perception, Scene
from evastudio.world.spaces import Array, Symbols

Progress = Callable[[float, str], None]
"""Told the share done, 0 to 1, and what is being done."""

N_NEIGHBORS = 25
"""The paper's 5 is out-voted by mistakes that lie together in state, and is too few to tell how
much demonstrations differ there."""
THRESHOLD = "auto"
"""The paper's l = 5 and 0.1 cut 47 % of the scripted human-like pilot's pairs and 93 % of its
strong turns, and k-NN then crossed 82 to 88 % of the fields, not 97. What "auto" finds and leaves
is in docs/conflicts.md."""
GAP_S = 0.6
"""Pairs this close in time are not compared: a mistake rarely lasts longer."""


def silent(share: float, doing: str) -> None:
    """A `Progress` that tells nobody."""


@dataclass(frozen=True)
class Cleaning:
    """What conflict elimination found in some pairs. It leaves nothing out by itself."""

    conflicts: NDArray[np.bool_]
    """Which pairs conflict with their neighbours, shape (pairs,)."""
    deviations: Array
    """Distance of each action from its neighbours' median, as a share of the range, (pairs,)."""
    limits: Array
    """The deviation beyond which each pair is a conflict, (pairs,)."""
    takes: NDArray[np.int64]
    """The take each pair came from, (pairs,)."""
    span: Array
    """The range of each component of the action, (m,); for symbols (0,)."""
    n_neighbors: int
    threshold: float | str
    """As asked for: a share of the range, or "auto"."""
    gap: int
    """Decision steps within which pairs of one take were not compared."""
    eliminator: ConflictEliminator = field(repr=False, compare=False)
    """As fitted, to tell what each pair was compared with."""

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
        """The figures, as JSON holds them; of `takes` each with its number of conflicts.

        `eta` is the middle limit in units of each component of the action; empty for symbols.
        """
        found = int(self.conflicts.sum())
        return {
            "pairs": len(self.conflicts),
            "conflicts": found,
            "kept": len(self.conflicts) - found,
            "share": found / len(self.conflicts),
            "n_neighbors": self.n_neighbors,
            "threshold": self.threshold,
            "eta": [float(part) for part in np.median(self.limits) * self.span],
            "takes": {
                str(take): int(self.conflicts[self.takes == take].sum())
                for take in np.unique(self.takes)
            },
        }


def clean_pairs(
    pairs: Pairs,
    scene: Scene,
    perception: str | Perception | None = None,
    *,
    n_neighbors: int = N_NEIGHBORS,
    threshold: float | str = THRESHOLD,
    progress: Progress = silent,
) -> Cleaning:
    """Find the conflicts among `pairs`, perceived through `perception` of `scene`.

    See `ConflictEliminator`. Raises NotFoundError for an unknown perception, InvalidInputError
    where there are too few pairs or they are not finite.
    """
    if len(pairs) == 0:
        raise InvalidInputError("There are no pairs to clean. Record a take first.")
    gap = round(GAP_S / scene.dt_s)
    if len(pairs) < n_neighbors + 2 * gap + 1:
        raise InvalidInputError(
            f"Cleaning compares every pair with its {n_neighbors} nearest others from other "
            f"moments, which needs {n_neighbors + 2 * gap + 1} pairs, and there are only "
            f"{len(pairs)}. Record more first."
        )
    progress(0.0, "Looking for conflicts")
    action = scene.chosen(scene.perception(perception))
    symbols = isinstance(action, Symbols)
    span = action.high - action.low
    known = span if not symbols and np.isfinite(span).all() else None
    eliminator = ConflictEliminator(n_neighbors, threshold, known, gap, symbols)
    eliminator.fit(pairs.states, pairs.actions, pairs.moments)
    progress(1.0, "Conflicts found")
    return Cleaning(
        conflicts=eliminator.conflict_mask_,
        deviations=eliminator.deviations_,
        limits=eliminator.limits_,
        takes=pairs.takes,
        span=np.empty(0) if symbols else eliminator.range_,
        n_neighbors=n_neighbors,
        threshold=threshold,
        gap=gap,
        eliminator=eliminator,
    )


def explain_cleaning(
    cleaning: Cleaning, pairs: Pairs, numbers: ArrayLike | None = None
) -> tuple[Conflict, ...]:
    """What each marked pair, or each of `numbers`, was compared with; see `Conflict`.

    `pairs` are those that were looked at. Raises InvalidInputError where they are not, or where
    there is no pair of such a number.
    """
    cleaning.apply(pairs)
    return cleaning.eliminator.explain(numbers)
