"""Push-T as the pusher sees it: two perceptions of the same five numbers.

A state of the world is agent x and y, block x and y, and the block's angle; an action is the
place the agent is drawn to next, in pixels of a square of 512. The block is a T, its mirror axis
the y axis of its own frame, and belongs at GOAL.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from evastudio.world.spaces import Array

GOAL = np.array([256.0, 256.0, np.pi / 4])
"""Where the block belongs: x, y, angle."""


@dataclass(frozen=True)
class Percept:
    """What is seen, and what is needed to turn an answer back."""

    states: Array
    """Shape (rows, n)."""
    agents: Array
    """Agent positions in the world, shape (rows, 2)."""
    turns: Array
    """Matrices from the world's frame to the own one, shape (rows, 2, 2)."""


class Perception:
    """The five numbers as they were recorded; actions relative to the agent.

    A target in absolute numbers would nearly be a copy of the agent's position.
    """

    name = "plain"

    def perceive(self, worlds: Array) -> Percept:
        """What is seen of `worlds` (rows, 5)."""
        turns = np.broadcast_to(np.eye(2), (len(worlds), 2, 2))
        return Percept(worlds, worlds[:, :2], turns)

    def to_own(self, percept: Percept, targets: Array) -> Array:
        """Targets (rows, 2) in the world, as steps from the agent in the own frame."""
        return np.einsum("rij,rj->ri", percept.turns, targets - percept.agents)

    def to_world(self, percept: Percept, actions: Array) -> Array:
        """What `to_own` undoes: steps (rows, 2) to targets, kept within the square."""
        targets = percept.agents + np.einsum("rji,rj->ri", percept.turns, actions)
        return np.clip(targets, 0.0, 512.0)


class BlockPerception(Perception):
    """Agent and goal in the block's frame, mirrored so that the block must turn left.

    Six numbers: the agent's position, the goal's position, cosine and sine of the goal's angle.
    What looks the same from the block is the same, wherever on the square it lies.
    """

    name = "block"

    def perceive(self, worlds: Array) -> Percept:
        """What is seen of `worlds` (rows, 5)."""
        angle = worlds[:, 4]
        turns = rotations(-angle)
        apart = (GOAL[2] - angle + np.pi) % (2 * np.pi) - np.pi
        side = np.where(apart < 0.0, -1.0, 1.0)
        turns[:, 0] *= side[:, None]
        agent = np.einsum("rij,rj->ri", turns, worlds[:, :2] - worlds[:, 2:4])
        goal = np.einsum("rij,rj->ri", turns, GOAL[:2] - worlds[:, 2:4])
        states = np.column_stack([agent, goal, np.cos(apart), np.sin(np.abs(apart))])
        return Percept(states, worlds[:, :2], turns)


def rotations(angles: Array) -> Array:
    """Matrices that rotate by `angles` (rows,), shape (rows, 2, 2)."""
    cos, sin = np.cos(angles), np.sin(angles)
    return np.stack([np.stack([cos, -sin], axis=1), np.stack([sin, cos], axis=1)], axis=1)


PERCEPTIONS = (Perception(), BlockPerception())
