"""A lineup: up to four runs of one world side by side, at one moment, seen by one camera."""

from __future__ import annotations

import logging
import secrets
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from evastudio.errors import not_found
from evastudio.live.picture import Picture, Show
from evastudio.live.pulse import Pulse
from evastudio.live.reel import Reel
from evastudio.live.review import Review
from evastudio.live.strip import Happening, strip_of
from evastudio.live.turned import as_seen, is_near, placed
from evastudio.world.bodies import Camera, Line
from evastudio.world.scene import Scene
from evastudio.world.snapshot import Snapshot

logger = logging.getLogger(__name__)

FRAMES_PER_S = 60.0
"""Drawn at most of all columns together: a browser draws each of them by itself."""
REST_S = 3600.0
"""Where nothing moves nothing is due."""
APART_M = 0.3
"""Leads further apart than this have parted."""
COLORS = ((86, 180, 233), (230, 159, 0), (0, 190, 140), (214, 130, 180))
"""Of the ways in the columns, told apart by people who see few colours; the page has the same."""
OWN_PIXELS, OTHER_PIXELS = 4.0, 1.5


@dataclass(frozen=True)
class Ran:
    """One run of a lineup's world."""

    title: str
    """Who it is, as people read it."""
    reel: Reel


@dataclass(frozen=True)
class Standing:
    """Where a lineup is."""

    position_s: float
    speed: float
    """How fast it goes on; 0 where it stands."""
    camera: str
    turned: bool
    """Whether a person turned the cameras from where the scene has them."""


class Column:
    """One run, seen at the moment its lineup is at. Its methods may be called from any thread."""

    def __init__(self, lineup: Lineup, ran: Ran, parts: int | None) -> None:
        self.name = secrets.token_hex(6)
        """Of its view; says nothing of who it is."""
        self.title = ran.title
        self.reel = ran.reel
        self.parts_s = None if parts is None else parts * ran.reel.scene.dt_s
        """When it is no longer where the first column is; None where it always is."""
        self.happenings: list[Happening] = strip_of(ran.reel, ran.reel.moments()).happenings
        self.lines: tuple[Line, ...] = ()
        """The ways that are drawn into it."""
        self.shows: list[Show] = []
        self._lineup = lineup

    @property
    def scene(self) -> Scene:
        return self.reel.scene

    @property
    def length_s(self) -> float:
        return self.reel.last * self.scene.dt_s

    @property
    def outcome(self) -> str | None:
        """What became of it, or None where it was still going on."""
        code = int(self.scene.outcome(self.reel.moment(self.reel.last))[0])
        return self.scene.outcomes[code] if code else None

    def watch(self, show: Show) -> None:
        """See `Shown.watch`."""
        self._lineup.watch(self, show)

    def unwatch(self, show: Show) -> None:
        """See `Shown.unwatch`."""
        self._lineup.unwatch(self, show)

    def turned(self, before: Camera, now: Camera) -> None:
        """A person turned the camera `before`, that this was seen from, to `now`; does not wait."""
        self._lineup.turned(self, before, now)


class Lineup:
    """Runs that begin in the same moment of the same world, on one timeline.

    It has a thread of its own, which draws; its methods may be called from any thread.
    """

    def __init__(self, name: str, runs: Sequence[Ran], *, ways: bool = True) -> None:
        """`runs` of one scene; with `ways` each column shows where all of them go."""
        self.name = name
        reels = [ran.reel for ran in runs]
        parts = parting(reels)
        self.columns = [Column(self, ran, at) for ran, at in zip(runs, parts, strict=True)]
        self.scene = reels[0].scene
        longest = max(reels, key=lambda reel: reel.last)
        self.length_s = longest.last * self.scene.dt_s
        self.parts_s = min((c.parts_s for c in self.columns if c.parts_s is not None), default=None)
        """The first moment at which they are not all in one place; None where there is none."""
        self.cameras = tuple(self.scene.cameras(longest.moment(0)))
        self._camera = self.cameras[0]
        self._seen: Camera | None = None
        """Where a person looks from, in the frame of the scene's camera."""
        self._review = Review(longest, 0.0, time.monotonic())
        self._used_at = self._due = time.monotonic()
        if ways:
            self._draw_ways()
        self._pulse = Pulse(f"lineup-{name}", self._beat, self._failed)
        self._pulse.start()

    @property
    def bytes(self) -> int:
        """What its runs take in memory."""
        return sum(column.reel.bytes for column in self.columns)

    def idle_s(self, now: float) -> float:
        """For how long nobody has looked at it or done anything with it; `now` is monotonic."""
        return 0.0 if any(column.shows for column in self.columns) else now - self._used_at

    def standing(self) -> Standing:
        """Where it is now."""
        return self._pulse.call(self._stand)

    def seek(self, at_s: float) -> Standing:
        """Look at that second, or the last there is."""
        at = round(at_s / self.scene.dt_s, 6)
        return self._do(lambda: self._review.seek(at, time.monotonic()))

    def roll(self, speed: float) -> Standing:
        """See `Review.roll`; from the end it begins again."""

        def roll() -> None:
            review, now = self._review, time.monotonic()
            if speed > 0.0 and review.position >= review.reel.last:
                review.seek(float(review.reel.first), now)
            review.roll(speed, now)

        return self._do(roll)

    def look_through(self, camera: str | None = None) -> Standing:
        """See all of them through the scene's camera of that name, as the scene has it; through
        the present one where none is named. Raises NotFoundError."""
        if camera is not None and camera not in self.cameras:
            raise not_found(f"camera of scene {self.scene.name!r}", camera, self.cameras)

        def look() -> None:
            self._camera, self._seen = camera or self._camera, None

        return self._do(look)

    def watch(self, column: Column, show: Show) -> None:
        """Draw `column` for `show` from now on."""

        def begin() -> None:
            self._show(column, show, fresh=True)
            column.shows.append(show)

        self._pulse.call(begin)

    def unwatch(self, column: Column, show: Show) -> None:
        """Draw for `show` no more; does not wait."""

        def end() -> None:
            self._used_at = time.monotonic()
            column.shows.remove(show)

        self._pulse.post(end)

    def turned(self, column: Column, before: Camera, now: Camera) -> None:
        """Turn every other column as a person turned `column`; does not wait."""

        def turn() -> None:
            if not is_near(before, now):
                return
            of_scene = self._of_scene(self._moment(column))
            there = of_scene if self._seen is None else placed(of_scene, self._seen)
            # The browser may be some frames behind: what counts is how it was turned.
            self._seen = as_seen(of_scene, placed(there, as_seen(before, now)))
            for other in self.columns:
                if other is not column:
                    self._draw(other)

        self._pulse.post(turn)

    def close(self) -> None:
        """Stop the thread."""
        self._pulse.close()

    # -- the thread ----------------------------------------------------------------------------

    def _do(self, work: Callable[[], None]) -> Standing:
        """Do `work`, draw what it comes to, and tell where that is."""

        def do() -> Standing:
            self._used_at = time.monotonic()
            work()
            self._draw_all()
            return self._stand()

        return self._pulse.call(do)

    def _beat(self, _: bool) -> float:
        """Draw the next frame where it moves."""
        now = time.monotonic()
        if not self._review.speed:
            return now + REST_S
        if now < self._due:
            return self._due
        self._review.advance(now)
        self._draw_all()
        self._due = now + len(self.columns) / FRAMES_PER_S
        return self._due

    def _failed(self, error: Exception) -> None:
        logger.error("Lineup %s failed", self.name, exc_info=error)

    def _stand(self) -> Standing:
        review = self._review
        review.advance(time.monotonic())
        return Standing(review.seconds, review.speed, self._camera, self._seen is not None)

    def _draw_all(self) -> None:
        for column in self.columns:
            self._draw(column)

    def _draw(self, column: Column) -> None:
        for show in column.shows:
            self._show(column, show)

    def _show(self, column: Column, show: Show, fresh: bool = False) -> None:
        try:
            moment = self._moment(column)
            camera = self._of_scene(moment)
            seen = camera if self._seen is None else placed(camera, self._seen)
            show(Picture(moment, fresh, seen, column.lines))
        except Exception as error:  # scenes say what to draw, and scenes are other people's code
            self._failed(error)

    def _moment(self, column: Column) -> Snapshot:
        return column.reel.shown(self._review.position)

    def _of_scene(self, moment: Snapshot) -> Camera:
        return self.scene.cameras(moment)[self._camera]

    def _draw_ways(self) -> None:
        """Give each column the ways of all: they are drawn once, and stay."""
        ways = [_way(column.reel) for column in self.columns]
        for own in self.columns:
            own.lines = tuple(
                Line(
                    f"way {number}",
                    way,
                    np.tile(np.array(color, dtype=np.uint8), (len(way), 1)),
                    pixels=OWN_PIXELS if column is own else OTHER_PIXELS,
                )
                for number, (column, way, color) in enumerate(
                    zip(self.columns, ways, COLORS, strict=False)
                )
            )


def parting(reels: Sequence[Reel]) -> list[int | None]:
    """Of each of `reels` the first step at which its lead is away from that of the first.

    None where it is not while both last; so of the first itself.
    """
    ways = [_way(reel) for reel in reels]
    found: list[int | None] = []
    for way in ways:
        both = min(len(way), len(ways[0]))
        apart = np.linalg.norm(way[:both] - ways[0][:both], axis=1) > APART_M
        found.append(int(np.argmax(apart)) if apart.any() else None)
    return found


def _way(reel: Reel) -> NDArray[np.float32]:
    """Where the lead was at each step, (steps + 1, 3), metres."""
    places = [reel.place(step) for step in range(reel.first, reel.last + 1)]
    return np.array(places, dtype=np.float32)
