"""Thumbnails of takes: the way that was gone, seen from above, as a small SVG."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from evastudio.demonstrations.records import TakeData
from evastudio.world.cast import LEAD
from evastudio.world.scene import Scene
from evastudio.world.spaces import Array

DRAWING = 1
"""Raised with every change of what is drawn, so that nobody keeps an older one."""
WIDTH, HEIGHT, MARGIN = 128.0, 72.0, 9.0
LEAST_M = 12.0
"""So much of the world is seen at least."""
MOST_STRETCH = 6.0
"""A way that is long and hardly bends is drawn at most so much wider than it was."""
POINTS = 96
NEAR_M = 20.0
"""What stands still within so far of the way is hinted at."""
LARGE_M = 8.0
"""Larger things are no obstacles but the ground, or walls."""
SMALL_M = 0.2
MOST_THINGS = 90
MOST_OTHERS = 150
GROUND, THING, OTHER, ROAD = "#111827", "#46547a", "#8593b5", "#6fcbff"
GOOD, BAD, OPEN = "#63dca0", "#ff7d84", "#a3afc9"


def thumbnail(scene: Scene, data: TakeData, outcome: str | None) -> bytes:
    """An SVG of `data`, a take of `scene` that came to `outcome`; x goes right and y up.

    Where it was along what stands near the way, or among others, those are hinted at.
    """
    moments = data.snapshots
    chosen = np.unique(np.linspace(0, moments.worlds - 1, POINTS).round().astype(np.int64))
    way = scene.whereabouts(moments.take(chosen))
    page = _Page(way[:, :2])
    things = [
        f'<circle cx="{x:.1f}" cy="{y:.1f}" r="{max(r * page.scale, 0.9):.1f}"/>'
        for (x, y), r in _things(scene, data, way, page)
    ]
    others = [f'<circle cx="{x:.1f}" cy="{y:.1f}" r="1.4"/>' for x, y in _others(data, page)]
    points = page.at(way[:, :2])
    drawn = " ".join(f"{x:.1f},{y:.1f}" for x, y in points)
    (x0, y0), (x1, y1) = points[0], points[-1]
    end = OPEN if outcome is None else GOOD if outcome in scene.successes else BAD
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH:g} {HEIGHT:g}">',
        f'<rect width="{WIDTH:g}" height="{HEIGHT:g}" fill="{GROUND}"/>',
        f'<g fill="{THING}">{"".join(things)}</g>',
        f'<g fill="{OTHER}">{"".join(others)}</g>',
        f'<polyline points="{drawn}" fill="none" stroke="{ROAD}" stroke-width="2.2" '
        'stroke-linecap="round" stroke-linejoin="round"/>',
        f'<circle cx="{x0:.1f}" cy="{y0:.1f}" r="2.2" fill="{ROAD}"/>',
        f'<circle cx="{x1:.1f}" cy="{y1:.1f}" r="3.6" fill="{end}" stroke="{GROUND}" '
        'stroke-width="1.2"/>',
        "</svg>",
    ]
    return "".join(parts).encode()


class _Page:
    """How metres of the ground are units of the drawing."""

    def __init__(self, way: Array) -> None:
        """That shows all of `way` (points, 2)."""
        self._middle = (way.max(axis=0) + way.min(axis=0)) / 2.0
        room = np.array([WIDTH, HEIGHT]) - 2.0 * MARGIN
        span = np.maximum(way.max(axis=0) - way.min(axis=0), 1e-9)
        self.scale = float(min((room / span).min(), (room / LEAST_M).min()))
        """Units a metre, where it is least."""
        most = np.minimum(room / span, self.scale * MOST_STRETCH)
        bends = np.minimum(most, (room / LEAST_M).min())
        self._units = np.maximum(bends, self.scale) * [1.0, -1.0]

    def at(self, places: Array) -> Array:
        """Where `places` (n, 2) are on it, (n, 2)."""
        return np.asarray((places - self._middle) * self._units + [WIDTH / 2.0, HEIGHT / 2.0])

    def shows(self, points: Array) -> NDArray[np.bool_]:
        """Which `points` (n, 2) of it are within its edges."""
        return np.asarray(((points > 2.0) & (points < [WIDTH - 2.0, HEIGHT - 2.0])).all(axis=1))


def _things(scene: Scene, data: TakeData, way: Array, page: _Page) -> list[tuple[Array, float]]:
    """Where on the page, and how large in metres, things are that stand near the way."""
    still = [body for body in scene.bodies(data.snapshots.take(slice(0, 1))) if body.fixed]
    meshes = scene.meshes() if still else {}
    reach = np.c_[way, np.zeros(len(way))] if way.shape[1] == 2 else way
    found: list[tuple[float, Array, float]] = []
    for body in still:
        size = float(np.hypot(*meshes[body.mesh].vertices[:, :2].T).max())
        scales = np.asarray(body.scales, dtype=np.float64)
        radii = size * (scales if scales.ndim == 1 else scales[:, :2].max(axis=1))
        fit = (radii > SMALL_M) & (radii < LARGE_M)
        places = np.asarray(body.positions, dtype=np.float64)[fit]
        if len(places) == 0:
            continue
        apart = np.min([np.linalg.norm(places - point, axis=1) for point in reach], axis=0)
        on_page = page.at(places[:, :2])
        near = np.flatnonzero((apart < NEAR_M) & page.shows(on_page))
        found += [(float(apart[one]), on_page[one], float(radii[fit][one])) for one in near]
    found.sort(key=lambda one: one[0])
    return [(place, radius) for _, place, radius in found[:MOST_THINGS]]


def _others(data: TakeData, page: _Page) -> Array:
    """Where on the page those are at the end who do not lead, (n, 2)."""
    places, lead = data.snapshots.moving.get("position"), data.snapshots.moving.get(LEAD)
    if lead is None or places is None:
        return np.zeros((0, 2))
    points = page.at(np.delete(places[-1], int(lead[-1]), axis=0)[:, :2])
    return np.asarray(points[page.shows(points)][:MOST_OTHERS])
