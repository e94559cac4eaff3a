"""Unit quaternions (wxyz) in batches: along their last axis lie the components.

Results are stored component by component, so that each operation runs over long rows of numbers;
any layout is accepted. The dtype of the arguments is kept.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

Numbers = NDArray[Any]
"""float32 or float64."""

TINY = 1e-12


def components(array: Numbers) -> tuple[Numbers, ...]:
    """Views of `array` (..., k), one for each component."""
    return tuple(array[..., index] for index in range(array.shape[-1]))


def joined(*parts: Any) -> Numbers:
    """The inverse of `components`: parts of shape (...) become one array (..., k)."""
    shape = np.broadcast_shapes(*(np.shape(part) for part in parts))
    whole = np.empty((len(parts), *shape), dtype=np.result_type(*parts))
    for index, part in enumerate(parts):
        whole[index] = part
    return np.moveaxis(whole, 0, -1)


def product(first: Numbers, second: Numbers) -> Numbers:
    """The rotation that does `second`, then `first`; both (..., 4), broadcast."""
    aw, ax, ay, az = components(first)
    bw, bx, by, bz = components(second)
    return joined(
        aw * bw - ax * bx - ay * by - az * bz,
        aw * bx + ax * bw + ay * bz - az * by,
        aw * by - ax * bz + ay * bw + az * bx,
        aw * bz + ax * by - ay * bx + az * bw,
    )


def inverse(rotation: Numbers) -> Numbers:
    """The rotation back, (..., 4)."""
    w, x, y, z = components(rotation)
    return joined(w, -x, -y, -z)


def rotated(rotation: Numbers, vectors: Numbers) -> Numbers:
    """`vectors` (..., 3) turned by `rotation` (..., 4), broadcast."""
    w, x, y, z = components(rotation)
    vx, vy, vz = components(vectors)
    tx, ty, tz = 2 * (y * vz - z * vy), 2 * (z * vx - x * vz), 2 * (x * vy - y * vx)
    return joined(
        vx + w * tx + y * tz - z * ty,
        vy + w * ty + z * tx - x * tz,
        vz + w * tz + x * ty - y * tx,
    )


def about(axis: int, angle: Any) -> Numbers:
    """Rotation by `angle` (...) rad about x (0), y (1) or z (2), right-handed."""
    half = np.asarray(angle) / 2
    parts = [np.cos(half), *[np.zeros_like(half)] * 3]
    parts[1 + axis] = np.sin(half)
    return joined(*parts)


def normalized(array: Numbers) -> Numbers:
    """`array` (..., k) scaled to unit length."""
    parts = components(array)
    square = sum(part * part for part in parts)
    scale = 1 / np.sqrt(np.maximum(square, TINY))
    return joined(*(part * scale for part in parts))


def aligned(rotations: Numbers, reference: Numbers) -> Numbers:
    """`rotations`, each with the sign that lies nearer to `reference` (both stand for one turn)."""
    return np.where((rotations * reference).sum(axis=-1, keepdims=True) < 0, -rotations, rotations)


def continuous(rotations: Numbers) -> Numbers:
    """`rotations` (F, ..., 4) with signs that never jump from one moment to the next."""
    dots = (rotations[1:] * rotations[:-1]).sum(axis=-1)
    signs = np.concatenate([np.ones_like(dots[:1]), np.where(dots < 0, -1.0, 1.0)])
    return rotations * np.cumprod(signs, axis=0)[..., None]


def slerp(first: Numbers, second: Numbers, fraction: Any) -> Numbers:
    """Spherical interpolation along the shorter way (Shoemake 1985); `fraction` is 0 to 1."""
    second = aligned(second, first)
    share = np.asarray(fraction)[..., None]
    dot = np.clip((first * second).sum(axis=-1, keepdims=True), -1.0, 1.0)
    angle = np.arccos(dot)
    sine = np.sin(angle)
    near = sine < 1e-5
    safe = np.where(near, 1.0, sine)
    one = np.where(near, 1 - share, np.sin((1 - share) * angle) / safe)
    two = np.where(near, share, np.sin(share * angle) / safe)
    return normalized(one * first + two * second)


def between(first: Numbers, second: Numbers) -> Numbers:
    """The shortest rotation that takes direction `first` (..., 3) to `second` (..., 3)."""
    first, second = normalized(first), normalized(second)
    dot = (first * second).sum(axis=-1, keepdims=True)
    helper = np.where(np.abs(first[..., :1]) < 0.9, [1.0, 0.0, 0.0], [0.0, 1.0, 0.0])
    opposite = dot < -1 + 1e-9
    axis = np.where(opposite, np.cross(first, helper), np.cross(first, second))
    return normalized(np.concatenate([np.where(opposite, 0.0, 1 + dot), axis], axis=-1))


def from_axes(forward: Numbers, left: Numbers, up: Numbers) -> Numbers:
    """The rotation that takes x, y, z to these orthonormal directions, each (..., 3)."""
    a, d, g = components(forward)
    b, e, h = components(left)
    c, f, i = components(up)
    squares = joined(1 + a + e + i, 1 + a - e - i, 1 - a + e - i, 1 - a - e + i)
    largest = squares.argmax(axis=-1)
    x, y, z = h - f, c - g, d - b
    p, q, r = b + d, c + g, f + h
    w4, x4, y4, z4 = components(squares)
    w = np.choose(largest, [w4, x, y, z])
    u = np.choose(largest, [x, x4, p, q])
    v = np.choose(largest, [y, p, y4, r])
    t = np.choose(largest, [z, q, r, z4])
    return normalized(joined(w, u, v, t))
