"""Which joint of a foreign skeleton is which part of a body, by the names that are in use."""

from __future__ import annotations

import re
from collections.abc import Mapping

from evastudio.errors import InvalidInputError
from evastudio.motion.skeleton import Skeleton

PARTS: Mapping[str, tuple[str, ...]] = {
    "hips": ("hips", "hip", "pelvis", "root", "mainhips", "base"),
    "chest": ("chest", "spine2", "upperchest", "torso", "spine1", "thorax", "spine", "abdomen"),
    "head": ("head", "neck"),
    "upper_arm": ("upperarm", "uparm", "shldr", "shoulder", "arm", "humerus"),
    "forearm": ("lowerarm", "forearm", "loarm", "elbow", "radius"),
    "hand": ("hand", "wrist", "palm", "palm2", "middle1"),
    "thigh": ("upperleg", "upleg", "thigh", "hip", "femur"),
    "shank": ("lowerleg", "loleg", "leg", "knee", "shin", "calf", "tibia"),
    "foot": ("foot", "ankle"),
}
"""Names of joints without prefix, side and punctuation; the first that is found counts."""
SIDED = ("upper_arm", "forearm", "hand", "thigh", "shank", "foot")
OPTIONAL = ("chest", "head", "hand")
PREFIX = re.compile(r"^(mixamorig\d*[:_]|bip\d+[ _]|def[-_]|org[-_]|[a-z0-9]+:)", re.IGNORECASE)


def named_parts(skeleton: Skeleton) -> dict[str, int]:
    """The joint of each part that `skeleton` has: 'hips', 'left_thigh', ...

    Raises InvalidInputError, with the names that there are, where a body needs one more.
    """
    known: dict[tuple[str, str], int] = {}
    for joint, name in enumerate(skeleton.names):
        if name:
            known.setdefault(_plain(name), joint)
    found: dict[str, int] = {}
    for part, aliases in PARTS.items():
        for side in ("left", "right") if part in SIDED else ("",):
            name = f"{side}_{part}" if side else part
            present = [known[side, one] for one in aliases if (side, one) in known]
            if present:
                found[name] = present[0]
            elif part not in OPTIONAL:
                listed = ", ".join(name for name in skeleton.names[:24] if name)
                raise InvalidInputError(
                    f"No joint was found for the {name.replace('_', ' ')}; joints are named like "
                    f"'Left{aliases[0].title()}' or '{aliases[0]}.l'. There are: {listed}."
                )
    return found


def _plain(name: str) -> tuple[str, str]:
    """Side ('left', 'right' or '') and plain name of a joint."""
    bare = re.sub(r"_\d+$", "", PREFIX.sub("", name.strip()))
    side = ""
    for which, letter in (("left", "l"), ("right", "r")):
        sided = re.sub(rf"^{which}|{which}$", "", bare, flags=re.IGNORECASE)
        if sided == bare:  # .l, _L, L_, and a capital that ends or begins a name: FootL, LThigh
            sided = re.sub(
                rf"[._\- ][{letter}{letter.upper()}]$|^[{letter}{letter.upper()}][._\- ]"
                rf"|(?<=[a-z0-9]){letter.upper()}$|^[{letter}{letter.upper()}](?=[A-Z])",
                "",
                bare,
            )
        if sided != bare:
            bare, side = sided, which
            break
    return side, re.sub(r"[^a-z0-9]", "", bare.lower())
