"""Triangles on a canvas of numbers: the compiled part of `painter`.

It stands by itself rather than among the kernels: no policy and no world needs it, and nobody is to
wait for it to be compiled who makes no film.
"""

from __future__ import annotations

import math

import numba
import numpy as np
from numba import njit

from evastudio.world.compiled import code_folder

numba.config.CACHE_DIR = str(code_folder())

_SHARES = np.linspace(0.0, 1.0, 8192)
SRGB = np.where(_SHARES <= 0.0031308, 12.92 * _SHARES, 1.055 * _SHARES ** (1.0 / 2.4) - 0.055)
"""What a display is told, by amounts of light from 0 to 1."""
NEAR = 0.1
"""Metres before the camera at which what is seen begins."""


@njit(cache=True, nogil=True, fastmath=True, error_model="numpy")
def display(light, out):
    """Amounts of light as a display shows them: three.js's ACES filmic curve, then sRGB; 0 to 1.

    S. Hill's fit (github.com/TheRealMJP/BakingLab, ACES.hlsl), exposed by 1 / 0.6.
    """
    r, g, b = light[0] / 0.6, light[1] / 0.6, light[2] / 0.6
    x = 0.59719 * r + 0.35458 * g + 0.04823 * b
    y = 0.07600 * r + 0.90834 * g + 0.01566 * b
    z = 0.02840 * r + 0.13383 * g + 0.83777 * b
    x = (x * (x + 0.0245786) - 0.000090537) / (x * (0.983729 * x + 0.4329510) + 0.238081)
    y = (y * (y + 0.0245786) - 0.000090537) / (y * (0.983729 * y + 0.4329510) + 0.238081)
    z = (z * (z + 0.0245786) - 0.000090537) / (z * (0.983729 * z + 0.4329510) + 0.238081)
    out[0] = 1.60475 * x - 0.53108 * y - 0.07367 * z
    out[1] = -0.10208 * x + 1.10813 * y - 0.00605 * z
    out[2] = -0.00327 * x - 0.07276 * y + 1.07602 * z
    for k in range(3):
        out[k] = SRGB[int(min(max(out[k], 0.0), 1.0) * (len(SRGB) - 1) + 0.5)]


@njit(cache=True, nogil=True, fastmath=True, error_model="numpy")
def _shade(color, normal, glow, light, lit, out):
    """What a surface shows. Rows of `light`: sun's direction, sun, sky, ground.

    The sky's is strongest from the left (y), where three.js puts it that viser tells no place.
    """
    if glow:
        display(color, out)
        return
    x, y, z = normal
    long = math.sqrt(x * x + y * y + z * z) + 1e-12
    facing = max(x * light[0, 0] + y * light[0, 1] + z * light[0, 2], 0.0) / long
    up = 0.5 * y / long + 0.5
    for k in range(3):
        fall = facing * light[1, k] + up * light[2, k] + (1.0 - up) * light[3, k]
        lit[k] = color[k] * fall / math.pi
    display(lit, out)


@njit(cache=True, nogil=True, fastmath=True, error_model="numpy")
def _turn(wxyz, out):
    """The rotation of a unit quaternion as a matrix."""
    q, i, j, k = wxyz
    out[0] = 1 - 2 * (j * j + k * k), 2 * (i * j - k * q), 2 * (i * k + j * q)
    out[1] = 2 * (i * j + k * q), 1 - 2 * (i * i + k * k), 2 * (j * k - i * q)
    out[2] = 2 * (i * k - j * q), 2 * (j * k + i * q), 1 - 2 * (i * i + j * j)


@njit(cache=True, nogil=True, fastmath=True, error_model="numpy", inline="always")
def _within(start, grows, first, last):
    """Between which steps, `first` to `last` at most, what grows so much a step is not below 0."""
    if grows > 0.0:
        return max(first, -start / grows), last
    if grows < 0.0:
        return first, min(last, -start / grows)
    return (first, last) if start >= 0.0 else (1.0, 0.0)


@njit(cache=True, nogil=True, fastmath=True, error_model="numpy")
def _fill(points, colors, opacity, air, canvas, depths):
    """One triangle; `points` (3, 3): across and down the canvas, and one over metres ahead."""
    rows, columns = depths.shape
    ax, ay, da = points[0, 0], points[0, 1], points[0, 2]
    bx, by, db = points[1, 0], points[1, 1], points[1, 2]
    cx, cy, dc = points[2, 0], points[2, 1], points[2, 2]
    top = max(math.ceil(min(ay, by, cy) - 0.5), 0)
    low = min(math.floor(max(ay, by, cy) - 0.5), rows - 1)
    left = max(math.ceil(min(ax, bx, cx) - 0.5), 0)
    right = min(math.floor(max(ax, bx, cx) - 0.5), columns - 1)
    area = (bx - ax) * (cy - ay) - (by - ay) * (cx - ax)
    if area >= 0.0:  # seen from behind
        return
    plain = True
    for k in range(3):
        plain = plain and colors[0, k] == colors[1, k] and colors[0, k] == colors[2, k]
    right_u, right_v = (by - cy) / area, (cy - ay) / area  # what a step to the right adds
    right_w = -right_u - right_v
    deeper = right_u * da + right_v * db + right_w * dc
    for row in range(top, low + 1):
        x, y = left + 0.5, row + 0.5
        u = ((bx - x) * (cy - y) - (by - y) * (cx - x)) / area
        v = ((cx - x) * (ay - y) - (cy - y) * (ax - x)) / area
        first, last = _within(u, right_u, 0.0, float(right - left))
        first, last = _within(v, right_v, first, last)
        first, last = _within(1.0 - u - v, right_w, first, last)
        begin, end = math.ceil(first), math.floor(last)
        u, v = u + begin * right_u, v + begin * right_v
        depth = u * da + v * db + (1.0 - u - v) * dc
        for column in range(left + begin, left + end + 1):
            if depth > depths[row, column]:
                away = 1.0 / depth
                fog = 0.0
                if away > air[3]:
                    share = min((away - air[3]) / (air[4] - air[3]), 1.0)
                    fog = share * share * (3.0 - 2.0 * share)
                for k in range(3):
                    shown = colors[0, k]
                    if not plain:  # as far apart as in the world
                        shown = u * da * shown + v * db * colors[1, k]
                        shown = (shown + (1.0 - u - v) * dc * colors[2, k]) * away
                    shown += (air[k] - shown) * fog
                    canvas[row, column, k] += (shown - canvas[row, column, k]) * opacity
                if opacity >= 1.0:
                    depths[row, column] = depth
            u, v, depth = u + right_u, v + right_v, depth + deeper


@njit(cache=True, nogil=True, fastmath=True, error_model="numpy")
def _empty(points, count, rows, columns):
    """Whether what is between `count` points covers the middle of none of the canvas."""
    left, top = points[0, 0], points[0, 1]
    right, low = left, top
    for p in range(1, count):
        x, y = points[p, 0], points[p, 1]
        left, right, top, low = min(left, x), max(right, x), min(top, y), max(low, y)
    across = math.ceil(max(left, 0.0) - 0.5) > math.floor(min(right, columns) - 0.5)
    return across or math.ceil(max(top, 0.0) - 0.5) > math.floor(min(low, rows) - 0.5)


@njit(cache=True, nogil=True, fastmath=True, error_model="numpy")
def paint(
    vertices,
    normals,
    faces,
    flat,
    glow,
    opacity,
    places,
    turns,
    scales,
    colors,
    camera,
    focal,
    light,
    air,
    canvas,
    depths,
):
    """Paint every instance of a mesh.

    `vertices` and `normals` (V, 3), `faces` (F, 3); `places` (N, 3), `turns` (N, 4) unit
    quaternions, `scales` and linear `colors` (N, 3). `camera` (4, 3): right, down, ahead and where
    it is. `air` is the fog's colour (0 to 1), where it begins and ends. `canvas` is (rows, columns,
    3), 0 to 1 as shown, `depths` (rows, columns), one over metres.
    """
    rows, columns = depths.shape
    across, down = columns / 2 / focal, rows / 2 / focal
    reach = math.sqrt((vertices**2).sum(axis=1).max())
    world, seen, shown = np.empty_like(vertices), np.empty_like(vertices), np.empty_like(vertices)
    lit, normal, turned = np.empty(3), np.empty(3), np.empty((3, 3))
    points, tints = np.empty((3, 3)), np.empty((3, 3))
    cut, cut_tints = np.empty((4, 3)), np.empty((4, 3))
    for n in range(len(places)):
        large = reach * scales[n].max()
        offset = places[n] - camera[3]
        aside, above, ahead = camera[:3] @ offset
        if ahead < NEAR - large or ahead > air[4] + large:
            continue
        if abs(aside) > across * ahead + large * math.sqrt(1.0 + across * across):
            continue
        if abs(above) > down * ahead + large * math.sqrt(1.0 + down * down):
            continue
        _turn(turns[n], turned)
        wide, long, high = scales[n]
        for p in range(len(vertices)):
            x, y, z = vertices[p, 0] * wide, vertices[p, 1] * long, vertices[p, 2] * high
            for axis in range(3):
                world[p, axis] = turned[axis, 0] * x + turned[axis, 1] * y + turned[axis, 2] * z
                world[p, axis] += offset[axis]
            x, y, z = world[p, 0], world[p, 1], world[p, 2]
            for axis in range(3):
                seen[p, axis] = camera[axis, 0] * x + camera[axis, 1] * y + camera[axis, 2] * z
            if not flat:
                x, y, z = normals[p, 0] / wide, normals[p, 1] / long, normals[p, 2] / high
                for axis in range(3):
                    normal[axis] = turned[axis, 0] * x + turned[axis, 1] * y + turned[axis, 2] * z
                _shade(colors[n], normal, glow, light, lit, shown[p])
        for f in range(len(faces)):
            a, b, c = faces[f, 0], faces[f, 1], faces[f, 2]
            ox, oy, oz = world[a, 0], world[a, 1], world[a, 2]
            x, y, z = world[b, 0] - ox, world[b, 1] - oy, world[b, 2] - oz
            i, j, k = world[c, 0] - ox, world[c, 1] - oy, world[c, 2] - oz
            normal[0], normal[1], normal[2] = y * k - z * j, z * i - x * k, x * j - y * i
            if normal[0] * ox + normal[1] * oy + normal[2] * oz >= 0.0:  # seen from behind
                continue
            kept = 0
            for corner in range(3):
                one, other = faces[f, corner], faces[f, (corner + 1) % 3]
                inside, next_inside = seen[one, 2] >= NEAR, seen[other, 2] >= NEAR
                if inside:
                    for axis in range(3):
                        cut[kept, axis], cut_tints[kept, axis] = seen[one, axis], shown[one, axis]
                    kept += 1
                if inside != next_inside:
                    share = (NEAR - seen[one, 2]) / (seen[other, 2] - seen[one, 2])
                    for axis in range(3):
                        from_, to = seen[one, axis], seen[other, axis]
                        cut[kept, axis] = from_ + share * (to - from_)
                        from_, to = shown[one, axis], shown[other, axis]
                        cut_tints[kept, axis] = from_ + share * (to - from_)
                    kept += 1
            for p in range(kept):
                depth = 1.0 / cut[p, 2]
                cut[p, 0] = columns / 2 + focal * cut[p, 0] * depth
                cut[p, 1] = rows / 2 + focal * cut[p, 1] * depth
                cut[p, 2] = depth
            if kept == 0 or _empty(cut, kept, rows, columns):
                continue
            if flat:
                _shade(colors[n], normal, glow, light, lit, cut_tints[0])
                for p in range(1, kept):
                    for axis in range(3):
                        cut_tints[p, axis] = cut_tints[0, axis]
            for last in range(2, kept):
                for axis in range(3):
                    points[0, axis], tints[0, axis] = cut[0, axis], cut_tints[0, axis]
                    points[1, axis], tints[1, axis] = cut[last - 1, axis], cut_tints[last - 1, axis]
                    points[2, axis], tints[2, axis] = cut[last, axis], cut_tints[last, axis]
                _fill(points, tints, opacity, air, canvas, depths)


@njit(cache=True, nogil=True, fastmath=True, error_model="numpy")
def finished(canvas, fine, picture):
    """The canvas as a picture of bytes, `fine` by `fine` of its points in each of the picture's."""
    rows, columns, _ = picture.shape
    for row in range(rows):
        for column in range(columns):
            for k in range(3):
                sum_ = 0.0
                for y in range(fine):
                    for x in range(fine):
                        sum_ += canvas[row * fine + y, column * fine + x, k]
                picture[row, column, k] = np.uint8(255.0 * sum_ / (fine * fine) + 0.5)
