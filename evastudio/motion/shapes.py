"""What the shipped body looks like: a few low-poly meshes, and palettes that tell people apart."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from evastudio.motion.body import FOREARM, SHANK, THIGH, UPPER_ARM
from evastudio.world.bodies import Mesh

Ring = tuple[float, float, float, float]
"""Height, half width along x and y, and centre along x."""

SKIN = np.array(
    [(255, 214, 182), (240, 186, 148), (214, 154, 112), (166, 110, 76), (120, 78, 54), (92, 60, 44)]
)
HAIR = np.array(
    [(46, 34, 30), (92, 58, 34), (146, 92, 46), (218, 176, 96), (178, 74, 40), (150, 150, 155)]
)
TOPS = np.array(
    [
        (232, 74, 66),
        (250, 158, 48),
        (246, 205, 70),
        (86, 176, 98),
        (44, 160, 172),
        (62, 112, 206),
        (138, 88, 190),
        (236, 112, 158),
        (238, 234, 222),
        (64, 72, 92),
    ]
)
TROUSERS = np.array(
    [
        (48, 62, 96),
        (62, 58, 62),
        (120, 96, 74),
        (74, 104, 134),
        (104, 112, 84),
        (150, 138, 120),
        (86, 54, 66),
    ]
)
SHOES = np.array([(240, 240, 236), (48, 44, 46), (140, 84, 50), (210, 66, 58)])
EYES = (34, 30, 38)
LOOKS = 4096
"""How many looks there are before they repeat."""


@dataclass(frozen=True)
class Limb:
    """One drawn part of a body."""

    joint: str
    """What it moves with: one of `figures.JOINTS`."""
    mesh: str
    size: tuple[float, float, float] = (1.0, 1.0, 1.0)
    """Scale of the mesh along x, y, z in the joint's frame."""
    color: str = "skin"
    """Which colour of a look it takes."""


def _limbs() -> tuple[Limb, ...]:
    limbs = [
        Limb("hips", "hips", color="trousers"),
        Limb("chest", "torso", color="top"),
        Limb("head", "head"),
        Limb("head", "eyes", color="eyes"),
    ]
    for side in ("left", "right"):
        limbs += [
            Limb(f"{side}_upper_arm", "limb", (0.058, 0.055, UPPER_ARM), "top"),
            Limb(f"{side}_forearm", "limb", (0.045, 0.042, FOREARM), "sleeve"),
            Limb(f"{side}_hand", "hand"),
            Limb(f"{side}_thigh", "limb", (0.085, 0.08, THIGH), "trousers"),
            Limb(f"{side}_shank", "limb", (0.062, 0.058, SHANK), "leg"),
            Limb(f"{side}_foot", "shoe", color="shoe"),
        ]
    return tuple(limbs)


LIMBS = _limbs()
HAIRCUTS = ("hair_short", "hair_long", "hair_bun")


@lru_cache(maxsize=1)
def wardrobe() -> Mapping[str, NDArray[np.uint8]]:
    """The colours of each look, by what they are for: shape (LOOKS, 3) each."""
    rng = np.random.default_rng(20)

    def pick(colors: NDArray[np.int64], vary: float = 0.0) -> NDArray[np.int64]:
        chosen = colors[rng.integers(len(colors), size=LOOKS)]
        return (chosen * rng.uniform(1 - vary, 1 + vary, (LOOKS, 1))).clip(0, 255).astype(np.int64)

    skin, top, trousers = pick(SKIN, 0.05), pick(TOPS, 0.1), pick(TROUSERS, 0.12)
    bare_arms = rng.uniform(size=(LOOKS, 1)) < 0.5
    bare_legs = rng.uniform(size=(LOOKS, 1)) < 0.2
    colors = {
        "skin": skin,
        "hair": pick(HAIR, 0.12),
        "top": top,
        "trousers": trousers,
        "sleeve": np.where(bare_arms, skin, top),
        "leg": np.where(bare_legs, skin, trousers),
        "shoe": pick(SHOES),
        "eyes": np.tile(EYES, (LOOKS, 1)),
    }
    return {name: color.astype(np.uint8) for name, color in colors.items()}


@lru_cache(maxsize=1)
def builds() -> NDArray[np.float32]:
    """How broad each look is beside the plain one, shape (LOOKS,)."""
    return np.random.default_rng(21).uniform(0.88, 1.16, LOOKS).astype(np.float32)


@lru_cache(maxsize=1)
def meshes() -> Mapping[str, Mesh]:
    """By name, in the frames of their joints; size 1."""
    limb = [(0.1, 0.5, 0.5, 0), (0.0, 1, 1, 0), (-0.45, 0.98, 0.98, 0), (-1, 0.74, 0.74, 0)]
    limb.append((-1.07, 0.4, 0.4, 0))
    torso = [(-0.05, 0.1, 0.125, 0.0), (0.08, 0.112, 0.14, 0.0), (0.24, 0.13, 0.172, 0.005)]
    torso += [(0.35, 0.115, 0.195, 0.0), (0.41, 0.085, 0.14, -0.005), (0.44, 0.05, 0.06, 0.0)]
    hips = [(0.13, 0.102, 0.13, 0.0), (0.05, 0.115, 0.155, 0.0), (-0.06, 0.112, 0.15, -0.005)]
    hips.append((-0.11, 0.06, 0.08, -0.005))
    head = [(-0.04, 0.05, 0.052, 0.0), (0.045, 0.048, 0.05, 0.005), (0.06, 0.08, 0.07, 0.025)]
    head += [(0.12, 0.115, 0.1, 0.022), (0.2, 0.128, 0.113, 0.015), (0.27, 0.112, 0.1, 0.005)]
    head.append((0.315, 0.055, 0.05, 0.0))
    short = [(0.12, 0.07, 0.09, -0.07), (0.19, 0.105, 0.118, -0.045), (0.25, 0.135, 0.118, 0.0)]
    short += [(0.31, 0.1, 0.09, -0.002), (0.34, 0.05, 0.045, -0.005)]
    long = [(-0.06, 0.05, 0.095, -0.09), (0.06, 0.065, 0.118, -0.08), *short[1:]]
    bun = [(0.28, 0.03, 0.03, -0.12), (0.31, 0.06, 0.06, -0.115), (0.36, 0.062, 0.062, -0.11)]
    bun.append((0.39, 0.03, 0.03, -0.105))
    hand = [(0.015, 0.026, 0.022, 0), (-0.05, 0.044, 0.024, 0.006), (-0.1, 0.042, 0.022, 0.01)]
    hand.append((-0.14, 0.02, 0.013, 0.012))
    shoe = [(0.03, 0.05, 0.045, -0.012), (-0.015, 0.07, 0.048, 0.0), (-0.05, 0.125, 0.056, 0.042)]
    shoe.append((-0.085, 0.135, 0.058, 0.046))
    nose = [(0.125, 0.022, 0.018, 0.135), (0.15, 0.024, 0.018, 0.138), (0.185, 0.008, 0.01, 0.125)]
    white = (255, 255, 255)

    def made(*parts: tuple[NDArray[np.float64], NDArray[np.int64]]) -> Mesh:
        starts = np.cumsum([0, *(len(vertices) for vertices, _ in parts)])
        faces = [shape + start for (_, shape), start in zip(parts, starts, strict=False)]
        return Mesh(np.concatenate([v for v, _ in parts]), np.concatenate(faces), white, flat=True)

    eye = _lofted([(0.165, 0.008, 0.01, 0), (0.185, 0.014, 0.016, 0), (0.205, 0.008, 0.01, 0)], 6)
    eyes = [(eye[0] + (0.128, side * 0.047, 0.005), eye[1]) for side in (1, -1)]
    return {
        "limb": made(_lofted(limb, 8)),
        "torso": made(_lofted(torso, 10)),
        "hips": made(_lofted(hips, 10)),
        "head": made(_lofted(head, 10), _lofted(nose, 5)),
        "eyes": made(*eyes),
        "hand": made(_lofted(hand, 6)),
        "shoe": made(_lofted(shoe, 8)),
        "shadow": _disc(),
        "hair_short": made(_lofted(short, 10)),
        "hair_long": made(_lofted(long, 10)),
        "hair_bun": made(_lofted(short, 10), _lofted(bun, 7)),
    }


def _disc(sides: int = 16) -> Mesh:
    """A soft shadow on the ground, of radius 1."""
    angle = 2 * np.pi * np.arange(sides) / sides
    rim = np.stack([np.cos(angle), np.sin(angle), np.zeros(sides)], axis=1)
    faces = [(sides, side, (side + 1) % sides) for side in range(sides)]
    vertices = np.concatenate([rim, np.zeros((1, 3))])
    return Mesh(vertices, np.array(faces), (16, 18, 30), opacity=0.32)


def _lofted(rings: Sequence[Ring], sides: int) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """A closed surface through elliptic rings at rising or falling heights."""
    ordered = sorted(rings)
    angle = 2 * np.pi * (np.arange(sides) + 0.5) / sides
    vertices = [
        np.stack([x + wide * np.cos(angle), deep * np.sin(angle), np.full(sides, z)], axis=1)
        for z, wide, deep, x in ordered
    ]
    ends = [(ordered[0][3], 0.0, ordered[0][0]), (ordered[-1][3], 0.0, ordered[-1][0])]
    low, high = len(ordered) * sides, len(ordered) * sides + 1
    faces = []
    for ring in range(len(ordered) - 1):
        for side in range(sides):
            a, b = ring * sides + side, ring * sides + (side + 1) % sides
            faces += [(a, b, b + sides), (a, b + sides, a + sides)]
    top = (len(ordered) - 1) * sides
    for side in range(sides):
        after = (side + 1) % sides
        faces += [(low, after, side), (high, top + side, top + after)]
    return np.concatenate([*vertices, np.array(ends)]), np.array(faces)
