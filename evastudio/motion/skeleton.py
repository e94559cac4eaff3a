"""A skeleton: named joints in a tree, and where its clips put them."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from evastudio.errors import InvalidInputError
from evastudio.motion.rotations import normalized, product, rotated
from evastudio.world.spaces import Array

MOST_JOINTS = 1024
LARGEST = 1e9
"""No coordinate is larger, in any unit: what is would overflow further on."""


@dataclass(frozen=True)
class Skeleton:
    """Joints, each after its parent. Raises InvalidInputError where they are no such tree."""

    names: tuple[str, ...]
    parents: tuple[int, ...]
    """Index of each joint's parent, which comes before it; -1 for a root."""
    offsets: Array
    """Shape (J, 3): each joint at rest, in its parent's frame."""
    rests: Array = field(default_factory=lambda: np.zeros((0, 4)))
    """Shape (J, 4): each joint's rotation at rest, in its parent's frame; none where left out."""

    def __post_init__(self) -> None:
        count = len(self.names)
        if not 1 <= count <= MOST_JOINTS:
            raise InvalidInputError(
                f"The skeleton has {count} joints; it must have 1 to {MOST_JOINTS}."
            )
        if len(self.rests) == 0:
            object.__setattr__(self, "rests", np.tile([1.0, 0.0, 0.0, 0.0], (count, 1)))
        for name, array, shape in (
            ("parents", np.asarray(self.parents), (count,)),
            ("offsets", self.offsets, (count, 3)),
            ("rests", self.rests, (count, 4)),
        ):
            if array.shape != shape or not (np.abs(array) <= LARGEST).all():
                raise InvalidInputError(
                    f"The skeleton's {name} have shape {array.shape}, or hold NaN or numbers "
                    f"beyond {LARGEST:g}; expected finite numbers of shape {shape}, one row for "
                    "each joint."
                )
        for joint, parent in enumerate(self.parents):
            if not -1 <= parent < joint:
                raise InvalidInputError(
                    f"Joint {self.names[joint]!r} hangs on joint number {parent}, which does not "
                    "come before it; a skeleton is a tree without circles."
                )

    def posed(self, translations: Array, rotations: Array) -> tuple[Array, Array]:
        """Positions (..., J, 3) and orientations (..., J, 4) of all joints in the world.

        `translations` (..., J, 3) and `rotations` (..., J, 4) are those of each joint in its
        parent's frame.
        """
        positions = np.array(np.broadcast_to(translations, (*rotations.shape[:-1], 3)))
        turns = np.array(rotations)
        for joint, parent in enumerate(self.parents):
            if parent >= 0:
                above = turns[..., parent, :]
                positions[..., joint, :] = positions[..., parent, :] + rotated(
                    above, positions[..., joint, :]
                )
                turns[..., joint, :] = product(above, turns[..., joint, :])
        return positions, turns

    def at_rest(self) -> tuple[Array, Array]:
        """Positions (J, 3) and orientations (J, 4) of the joints at rest."""
        return self.posed(self.offsets, normalized(self.rests))


def in_tree_order(parents: list[int]) -> NDArray[np.int64]:
    """An order of joints in which each comes after its parent.

    Raises InvalidInputError for parents that do not exist or go round in a circle.
    """
    count = len(parents)
    children: list[list[int]] = [[] for _ in range(count)]
    order: list[int] = []
    for joint, parent in enumerate(parents):
        if not -1 <= parent < count:
            raise InvalidInputError(
                f"Joint {joint} hangs on joint {parent}, but there are only {count} joints."
            )
        if parent >= 0:
            children[parent].append(joint)
        else:
            order.append(joint)
    for joint in order:  # grows while it is walked
        order.extend(children[joint])
    if len(order) != count:
        raise InvalidInputError(
            f"{count - len(order)} joints of the skeleton hang on each other in a circle; every "
            "joint must lead to a root."
        )
    return np.array(order, dtype=np.int64)
