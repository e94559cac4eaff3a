"""A take in the making: what its recorder knows of it, and its pairs as they are kept."""

from __future__ import annotations

import uuid
from collections.abc import Sequence
from dataclasses import asdict, dataclass, field
from typing import Any

import numpy as np

from evastudio.demonstrations.packing import pack
from evastudio.demonstrations.records import Origin
from evastudio.demonstrations.spill_file import BEGIN, Entry
from evastudio.demonstrations.store import pack_pairs
from evastudio.world.scene import Scene
from evastudio.world.snapshot import AnyArray, Snapshot
from evastudio.world.spaces import Array

Row = tuple[Array, Array, Snapshot]
"""State (1, n), action (1, m), or those of all characters (1, characters, m), and moment of one
decision step."""


@dataclass
class Running:
    """A take as its recorder sees it. Only its keeping thread touches `begin`, `kept`, `broken`."""

    scene: Scene
    session: int
    seed: int
    pilot: str
    perception: str
    snapshot: Snapshot
    started_at: float
    origin: Origin | None = None
    key: str = field(default_factory=lambda: uuid.uuid4().hex)
    pairs: int = 0
    buffer: list[Row] = field(default_factory=list)
    begin: Entry | None = None
    kept: int = 0
    broken: bool = False
    """Pairs could not be packed: what follows would not continue the take."""

    def beginning(self) -> Entry:
        values: dict[str, Any] = {
            "session": self.session,
            "scene_version": self.scene.version,
            "seed": self.seed,
            "options": dict(self.scene.values),
            "dt_s": self.scene.dt_s,
            "pilot": self.pilot,
            "perception": self.perception,
            "started_at": self.started_at,
            "origin": None if self.origin is None else asdict(self.origin),
        }
        return Entry(BEGIN, self.key, values, pack(self.snapshot.fixed))


def packed_rows(rows: Sequence[Row]) -> bytes:
    """The pairs of `rows` as a chunk of the store holds them."""
    moving: dict[str, AnyArray] = {
        name: np.concatenate([snapshot.moving[name] for _, _, snapshot in rows])
        for name in rows[0][2].moving
    }
    states = np.concatenate([state for state, _, _ in rows])
    actions = np.concatenate([action for _, action, _ in rows])
    return pack_pairs(states, actions, moving)
