"""Retargeting: a clip of any two-legged skeleton as poses of the shipped body."""

from __future__ import annotations

import numpy as np

from evastudio.errors import InvalidInputError
from evastudio.motion.body import ANKLE, LEG
from evastudio.motion.clip import Clip
from evastudio.motion.naming import named_parts
from evastudio.motion.poses import Poses
from evastudio.motion.rotations import about, between, from_axes, inverse, product, rotated
from evastudio.motion.skeleton import Skeleton
from evastudio.world.spaces import Array

DOWN = np.array([0.0, 0.0, -1.0])
LEFT = np.array([0.0, 1.0, 0.0])


def retargeted(clip: Clip) -> Poses:
    """The poses of `clip`, on the ground, at the size of the shipped body, facing ahead.

    What the root travels is kept. Parts turn from the shipped body's rest as those of the clip
    turn from theirs, after arms and legs of the two have been laid in one direction; lengths are
    scaled by the height of the hips. Raises InvalidInputError where the skeleton lacks a part or
    cannot stand.
    """
    parts = named_parts(clip.skeleton)
    places, turns = clip.skeleton.at_rest()
    upright = _upright(clip.skeleton, parts, places)
    rest = {part: rotated(upright, places[joint]) for part, joint in parts.items()}
    toes = [rotated(upright, places[joint]) for joint in _feet(clip.skeleton, parts)]
    rest["lowest"] = min(toes, key=lambda place: float(place[2]))
    scale, drop = _scale(rest)
    moved, turned = clip.world()
    ahead = about(2, -_facing(clip, parts, upright, moved))
    frame = product(ahead, upright)

    def at(part: str) -> Array:
        return np.asarray(rotated(frame, moved[:, parts[part]]) * scale)

    def since_rest(part: str) -> Array:
        """How a part has turned from its rest, in our world."""
        turn = product(turned[:, parts[part]], inverse(turns[parts[part]]))
        return product(product(frame, turn), inverse(upright))

    def laid(part: str, end: str) -> Array:
        """The turn that lays our limb, which hangs down at rest, along that of the clip."""
        if end not in rest or _long(rest[end] - rest[part]) < 1e-9:
            return np.array([1.0, 0.0, 0.0, 0.0])
        return between(DOWN, rest[end] - rest[part])

    hips = since_rest("hips")
    chest = since_rest("chest") if "chest" in parts else hips
    head = since_rest("head") if "head" in parts else chest
    arms, fore, hands, ankles, feet, hinges = [], [], [], [], [], []
    for side in ("left", "right"):
        upper = product(
            since_rest(f"{side}_upper_arm"), laid(f"{side}_upper_arm", f"{side}_forearm")
        )
        along = laid(f"{side}_forearm", f"{side}_hand")
        lower = product(since_rest(f"{side}_forearm"), along)
        hand = product(since_rest(f"{side}_hand"), along) if f"{side}_hand" in parts else lower
        arms.append(product(inverse(chest), upper))
        fore.append(product(inverse(upper), lower))
        hands.append(product(inverse(lower), hand))
        ankles.append(at(f"{side}_foot") - (0.0, 0.0, drop))
        feet.append(since_rest(f"{side}_foot"))
        thigh = product(since_rest(f"{side}_thigh"), laid(f"{side}_thigh", f"{side}_shank"))
        hinges.append(rotated(thigh, LEFT))
    upper = np.stack(
        [hips, product(inverse(hips), chest), product(inverse(chest), head), *arms, *fore, *hands],
        axis=1,
    )
    root = (at("left_thigh") + at("right_thigh")) / 2
    poses = Poses(
        root, upper, np.stack(ankles, axis=1), np.stack(feet, axis=1), np.stack(hinges, axis=1)
    )
    return grounded(poses)


def grounded(poses: Poses) -> Poses:
    """`poses` moved so that they begin over the origin and their feet come down to the ground."""
    height = np.percentile(poses.soles()[..., 2].min(axis=(1, 2)), 5.0)
    shift = np.array([*poses.root[0, :2], height])
    return Poses(poses.root - shift, poses.upper, poses.ankles - shift, poses.feet, poses.hinges)


def _feet(skeleton: Skeleton, parts: dict[str, int]) -> list[int]:
    """The feet's joints and all that hang on them: toes, and where they end."""
    feet = {parts["left_foot"], parts["right_foot"]}
    for joint, parent in enumerate(skeleton.parents):
        if parent in feet:
            feet.add(joint)
    return sorted(feet)


def _upright(skeleton: Skeleton, parts: dict[str, int], places: Array) -> Array:
    """The turn from the file's world into ours, in which the rest pose stands and looks ahead."""
    left = places[parts["left_thigh"]] - places[parts["right_thigh"]]
    hip = (places[parts["left_thigh"]] + places[parts["right_thigh"]]) / 2
    foot = (places[parts["left_foot"]] + places[parts["right_foot"]]) / 2
    up = hip - foot
    tall, wide = _long(up), _long(left)
    if not (tall > 1e-6 and wide > 1e-6 * tall):
        raise InvalidInputError(
            f"The skeleton with root {skeleton.names[0]!r} has no legs of any length at rest, so "
            "it cannot be laid over the shipped body."
        )
    up = _snapped(up / tall)
    left = left / wide - up * (left / wide @ up)
    if _long(left) < 0.1:
        raise InvalidInputError(
            f"The hips of the skeleton with root {skeleton.names[0]!r} lie above one another at "
            "rest; a skeleton must stand upright at rest."
        )
    left = _snapped(left / _long(left))
    left = left - up * (left @ up)
    left = left / _long(left)
    return inverse(from_axes(np.cross(left, up), left, up))


def _scale(rest: dict[str, Array]) -> tuple[float, float]:
    """Our hips' height over that of the clip's skeleton, and by how much its ankles are higher."""
    long = np.mean(
        [
            _long(rest[f"{side}_shank"] - rest[f"{side}_thigh"])
            + _long(rest[f"{side}_foot"] - rest[f"{side}_shank"])
            for side in ("left", "right")
        ]
    )
    ankle = (rest["left_foot"][2] + rest["right_foot"][2]) / 2
    above = max(ankle - rest["lowest"][2], 0.1 * long)  # the sole, where no toe says it
    scale = LEG / (long + min(above, long))
    return float(scale), float(scale * min(above, long) - ANKLE)


def _snapped(direction: Array) -> Array:
    """The axis that `direction` nearly lies on, or itself."""
    axis = np.zeros(3)
    largest = int(np.abs(direction).argmax())
    axis[largest] = np.sign(direction[largest])
    return axis if abs(direction[largest]) > 0.85 else direction


def _facing(clip: Clip, parts: dict[str, int], upright: Array, moved: Array) -> float:
    """Yaw of the way it walks, or looks where it stays, in the upright frame, rad."""
    hip = [rotated(upright, moved[:, parts[f"{side}_thigh"]]) for side in ("left", "right")]
    middle = (hip[0] + hip[1]) / 2
    across = (hip[0] - hip[1]).mean(axis=0)
    looks = np.arctan2(-across[0], across[1])
    travel = middle[-1] - middle[0]
    if np.hypot(travel[0], travel[1]) > 2.0 * _long(hip[0][0] - hip[1][0]):
        way = np.arctan2(travel[1], travel[0])
        if np.cos(way - looks) > 0.7:
            looks = way
    return float(looks)


def _long(vector: Array) -> float:
    return float(np.linalg.norm(vector))
