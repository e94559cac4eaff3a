"""Running from a boulder that has come down: who lies, what one sees of it, and the way out.

Worlds with one hold `boulder` (3,): where it comes down, and seconds since it was let go, -1 while
there is none; and `hit` (N,), 1 for those whom the impact knocked over.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from evastudio.scenery.boulder import FALL_S
from evastudio.world.cast import of_lead
from evastudio.world.scene import Percept, Perception, Scene
from evastudio.world.snapshot import AnyArray, Snapshot
from evastudio.world.spaces import Array, Box, Field

RUN = 4.5
"""Metres a second of somebody who flees."""
HASTE = 6.0
"""Metres a second by which a runner's speed changes in a second."""
KNOCK = 3.5
"""Who stands nearer to the impact than this is knocked over."""
DOWN_S = 2.5
"""How long it takes to be up again."""


class Boulder(Perception):
    """Where the boulder lies, as one sees it, left and right made one.

    Without that the answers to a boulder straight ahead, a turn all the way to one side or to the
    other, would cancel out between neighbours.
    """

    name = "boulder"
    summary = "The direction of the boulder, seen from the character, whichever side it is on."
    state = Box((Field("ahead", "1", -1.0, 1.0), Field("aside", "1", 0.0, 1.0)))
    action = Box((Field("turn", "1", -1.0, 1.0), Field("walk", "1", 0.0, 1.0)))

    def __init__(self, scene: Scene) -> None:
        pass

    def perceive(self, snapshot: Snapshot) -> Percept:
        apart = snapshot["boulder"][:, None, :2] - snapshot["position"]
        bearing = np.arctan2(apart[:, :, 1], apart[:, :, 0]) - snapshot["heading"]
        ahead, left = np.cos(bearing), np.sin(bearing)
        side = np.where(left < 0.0, -1.0, 1.0)
        return Percept(np.stack([ahead, np.abs(left)], axis=2), side[:, :, None])

    def applies(self, snapshot: Snapshot) -> NDArray[np.bool_]:
        return np.asarray(
            of_lead(snapshot, ~lying(snapshot)) & (snapshot["boulder"][:, 2] >= FALL_S)
        )

    def to_own(self, frame: AnyArray, actions: Array) -> Array:
        return np.concatenate([actions[..., :1] * frame, actions[..., 1:2]], axis=-1)

    def to_world(self, frame: AnyArray, actions: Array) -> Array:
        besides = np.zeros((*actions.shape[:-1], 4))
        return np.concatenate([actions[..., :1] * frame, actions[..., 1:2], besides], axis=-1)


def fleeing(snapshot: Snapshot, size: int, haste: float) -> Array:
    """Away from the boulder: actions (worlds, N, size), of which the first two turn and run.

    haste: share of the turn away that is made in a decision.
    """
    apart = snapshot["position"] - snapshot["boulder"][:, None, :2]
    turn = np.arctan2(apart[:, :, 1], apart[:, :, 0]) - snapshot["heading"]
    actions = np.zeros((*turn.shape, size))
    actions[:, :, 0] = haste * (np.remainder(turn + np.pi, 2 * np.pi) - np.pi) / np.pi
    actions[:, :, 1] = 1.0
    return actions


def running(
    snapshot: Snapshot, actions: Array, boulder: Array, near: Array, dt_s: float
) -> dict[str, AnyArray]:
    """A step later: freely, each as fast as they want within what legs can do.

    boulder: as it is then. near: the positions that count at the impact, (worlds, N, 2).
    """
    impact = (boulder[:, 2] >= FALL_S) & (snapshot["boulder"][:, 2] < FALL_S)
    position = np.where(impact[:, None, None], near, snapshot["position"])
    apart = np.hypot(*(position - boulder[:, None, :2]).transpose(2, 0, 1))
    hit = snapshot["hit"] | (impact[:, None] & (apart < KNOCK))
    up = (hit == 0) | (boulder[:, 2:] >= FALL_S + DOWN_S)
    heading = snapshot["heading"] + np.where(up, actions[:, :, 0] * np.pi, 0.0)
    most = HASTE * dt_s
    change = np.clip(actions[:, :, 1] * RUN - snapshot["speed"], -most, most)
    speed = np.where(up, snapshot["speed"] + change, 0.0)
    distance = speed * dt_s
    way = np.stack([np.cos(heading), np.sin(heading)], axis=2)
    return {
        "position": position + way * distance[:, :, None],
        "heading": heading,
        "speed": speed,
        "hit": hit,
        "blocked": snapshot["blocked"],
    }


def lying(snapshot: Snapshot) -> NDArray[np.bool_]:
    """Who has been knocked over and is not up again, (worlds, N)."""
    return np.asarray((snapshot["hit"] > 0) & (snapshot["boulder"][:, 2:] < FALL_S + DOWN_S))
