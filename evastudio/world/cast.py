"""Who acts in a world: one character alone, or many, of which one leads.

In a scene of many characters states and actions have an axis for them behind that of the worlds,
and snapshots hold `lead`: whom an animator guides, and whom a take is about.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from evastudio.world.snapshot import AnyArray, Snapshot
from evastudio.world.spaces import Array

if TYPE_CHECKING:
    from evastudio.world.scene import Scene

LEAD = "lead"


def of_lead(snapshot: Snapshot, values: AnyArray) -> AnyArray:
    """The lead's part of `values` (worlds, characters, ...), shape (worlds, ...).

    Where one character acts alone, `values` as they are.
    """
    lead = snapshot.moving.get(LEAD)
    return values if lead is None else np.asarray(values[np.arange(len(lead)), lead])


def led_by(snapshot: Snapshot, character: int) -> Snapshot:
    """The same worlds led by `character`. Where one acts alone, `snapshot` as it is."""
    lead = snapshot.moving.get(LEAD)
    return snapshot if lead is None else snapshot.after(lead=np.full_like(lead, character))


def sound(scene: Scene, chosen: Array) -> Array:
    """Actions that somebody chose, (worlds, m) or (worlds, characters, m), within their range.

    Raises InvalidInputError for ones that are no numbers.
    """
    checked = scene.action.check(chosen.reshape(-1, chosen.shape[-1]), "actions chosen")
    return scene.action.clip(checked).reshape(chosen.shape)


def for_all(scene: Scene, snapshot: Snapshot, actions: Array, others: Array | None = None) -> Array:
    """Actions of all, (worlds, characters, m), of which the lead's are `actions` (worlds, m).

    The others do as in `others` (worlds, characters, m), or rest where that is None. Where one
    character acts alone, `actions` as they are.
    """
    if not scene.characters:
        return actions
    if others is None:
        others = scene.action.clip(np.zeros((len(actions), *scene.characters, actions.shape[1])))
    together = others.copy()
    together[np.arange(len(actions)), snapshot[LEAD]] = actions
    return together
