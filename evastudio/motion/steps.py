"""Finding the steps in a recording: one cycle of it as a gait whose feet stand still."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from evastudio.errors import InvalidInputError
from evastudio.motion.body import SOLES
from evastudio.motion.gait import PHASES, Gait, clearance, highest, stroke
from evastudio.motion.movements import closed
from evastudio.motion.poses import Poses
from evastudio.motion.rotations import rotated
from evastudio.world.spaces import Array

LONGEST_S = 30.0
"""Of a longer recording, only the first part is searched."""
CYCLE_S = (0.35, 5.0)
LOW = 0.035
"""Metres above the ground up to which a heel or ball may stand on it."""
SETTLING = 0.2
"""Share of a swing at each end in which the foot goes more up or down than ahead."""
SINKING = 0.09
"""Metres that hips may be lowered, now and then in a cycle, for feet that would not reach."""
SHORTEST = 0.75
"""Share of their length below which steps are not shortened for that."""
DUTY = (0.15, 0.85)
"""Share of a cycle that a foot stands."""


def gait_of(poses: Poses, rate_hz: float, name: str) -> Gait:
    """The clearest cycle of walking or running in `poses`, with root motion or without.

    Cycles are aligned by their touchdowns: left at phase 0, right at 0.5. What a foot stands on
    is then held still on the ground. Raises InvalidInputError, naming the clip, where there are
    no steps in it.
    """
    kept = min(len(poses), int(LONGEST_S * rate_hz))
    first, length = _cycle(poses.at(np.arange(float(kept))), rate_hz, name)
    moments = 4 * PHASES
    path = poses.at(np.asarray(first + np.arange(moments + 1) * (length / moments)))
    path = closed(path)
    ends = path.soles()
    pace, stands = _standing(ends, name)
    begins, lasts = zip(*(_longest(stands[:, foot]) for foot in (0, 1)), strict=True)
    ahead = np.mod(begins[1] - begins[0], 1.0)
    if not 0.2 <= ahead <= 0.8:
        ahead = 0.5
    phase = np.arange(PHASES) / PHASES
    warped = np.interp(phase, [0.0, 0.5, 1.0], [0.0, ahead, 1.0])
    places = np.mod(begins[0] + warped, 1.0) * moments
    level = path.at(places)
    # The same phases of the path, unwound: it moves on by `pace` a cycle.
    starts = np.interp(np.mod(np.array(begins) - begins[0], 1.0), [0.0, ahead, 1.0], [0, 0.5, 1])
    duties = np.clip(np.array(lasts), *DUTY)
    strokes = np.stack(
        [
            stroke(np.mod(phase - start, 1.0), duty)
            for start, duty in zip(starts, duties, strict=True)
        ],
        axis=1,
    )
    local = np.mod(phase[:, None] - starts, 1.0)
    ankles = np.stack(
        [_planted(level, foot, local[:, foot], duties[foot], pace) for foot in (0, 1)], axis=1
    )
    middle = ankles[..., 0].mean() - 0.02
    ankles[..., 0] -= middle
    root = level.root - (middle, level.root[:, 1].mean(), 0.0)
    ankles[..., 1] -= level.root[:, 1].mean()
    shorter = 1.0
    while True:  # long steps of short legs would pull the hips down: then take shorter ones
        laid = ankles.copy()
        laid[..., 0] += (shorter - 1.0) * pace * strokes
        over = root[:, 2] - highest(root, level.upper[:, 0], laid, local < duties)
        if over.max() - max(over.min(), 0.0) <= SINKING or shorter < SHORTEST:
            break
        shorter -= 0.04
    root[:, 2] += _lowered(over)
    pace, ankles = pace * shorter, laid
    speed = pace * rate_hz / length
    held = Poses(root, level.upper, ankles, level.feet, level.hinges)
    return Gait(held, strokes, duties, pace, speed)


def _cycle(poses: Poses, rate_hz: float, name: str) -> tuple[int, int]:
    """First moment and length of the stretch after which the pose comes back best."""
    ankles = poses.ankles - poses.root[:, None] * (1, 1, 0)
    shape = np.concatenate(
        [ankles.reshape(len(poses), 6), 0.5 * poses.upper.reshape(len(poses), 36)], axis=1
    )
    apart = ankles[:, 0, 0] - ankles[:, 1, 0]
    swing = np.ptp(apart)
    shortest = max(4, int(CYCLE_S[0] * rate_hz))
    longest = min(int(CYCLE_S[1] * rate_hz) + 1, len(poses) - 1)
    best = (np.inf, 0, 0)
    if swing > 0.05:
        for length in range(shortest, longest + 1):
            gap = np.abs(shape[length:] - shape[:-length]).mean(axis=1)
            spread = np.array(
                [np.ptp(apart[start : start + length + 1]) for start in range(len(gap))]
            )
            gap = np.where(spread > 0.7 * swing, gap, np.inf)
            start = int(gap.argmin())
            cost = gap[start] * (1 + 0.15 * length / rate_hz) + 0.002 * length / rate_hz
            if cost < best[0]:
                best = (float(cost), start, length)
    if not np.isfinite(best[0]):
        raise InvalidInputError(
            f"No two steps were found in clip {name!r}; a walk or run needs at least "
            f"{CYCLE_S[0]} s in which both feet step. Choose it for another activity."
        )
    return best[1], best[2]


def _standing(ends: Array, name: str) -> tuple[float, NDArray[np.bool_]]:
    """Metres a cycle, and when each foot stands: (F, 2) over the cycle without its last moment.

    Feet that stand move back at one speed: that is the speed of the walk.
    """
    moments = len(ends) - 1
    lower = ends[..., 2].argmin(axis=2)[..., None, None]
    height = np.take_along_axis(ends, lower, axis=2)[:-1, :, 0, 2]
    here = np.take_along_axis(ends[:-1], lower[:-1], axis=2)[:, :, 0, 0]
    there = np.take_along_axis(ends[1:], lower[:-1], axis=2)[:, :, 0, 0]
    back = (here - there) * moments
    floor = np.percentile(height, 2.0, axis=0)
    lift = np.ptp(height, axis=0)
    pace, low = 0.0, height < floor
    for share in (0.25, 0.08):  # of the lift; high jumps need the stricter one
        low = height < floor + np.maximum(LOW, share * lift)
        pace = float(np.median(back[low]))
        if pace >= 0.05:
            break
    if pace < 0.05:
        raise InvalidInputError(
            f"The feet of clip {name!r} do not push ahead, so it is no walk; choose it for another "
            "activity, or a clip that walks forward."
        )
    stands = low & (np.abs(back - pace) < 0.45 * pace)
    pace = float(np.median(back[stands])) if stands.any() else pace
    return pace, stands


def _longest(stands: NDArray[np.bool_]) -> tuple[float, float]:
    """Phase at which a foot begins to stand, and the share of the cycle that it does."""
    count = len(stands)
    if not stands.any() or stands.all():
        return 0.0, 0.5
    close = max(1, count // 16)
    wide = np.tile(stands, 3)
    filled = wide.copy()
    edges = np.flatnonzero(np.diff(wide.astype(np.int8)))
    for end, begin in pairwise(edges):
        if not wide[end + 1] and begin - end <= close:
            filled[end + 1 : begin + 1] = True
    best, first, run = 0, 0, 0
    for index in range(count, 3 * count):
        run = run + 1 if filled[index] else 0
        if best < run <= count:
            best, first = run, index - run + 1
    return (first % count) / count, best / count


def _planted(poses: Poses, foot: int, phase: Array, duty: float, pace: float) -> Array:
    """Where the ankle of one foot must be (PHASES, 3) so that what it stands on stays still."""
    order = np.argsort(phase, kind="stable")
    phase = phase[order]
    ankle = poses.ankles[order, foot]
    sole = rotated(poses.feet[order, foot, None], SOLES)
    ends = ankle[:, None] + sole
    count = int(np.searchsorted(phase, duty))
    lower = ends[..., 2].argmin(axis=1)
    shift = np.zeros((len(phase), 3))
    for index in range(1, count):
        end = lower[index - 1]
        moved = ends[index, end, :2] - ends[index - 1, end, :2]
        step = np.array([-pace * (phase[index] - phase[index - 1]), 0.0])
        shift[index, :2] = shift[index - 1, :2] + step - moved
    shift[:count, :2] -= shift[:count, :2].mean(axis=0)
    shift[:count, 2] = -ends[:count, :, 2].min(axis=1)
    free = (phase[count:] - duty) / (1 - duty)
    blend = (free * free * (3 - 2 * free))[:, None]
    shift[count:] = shift[count - 1] + blend * (shift[0] - shift[count - 1])
    shift[count:, :2] += _settled(ends + shift[:, None], phase, count, free, pace, int(lower[0]))
    height = (ends[count:, :, 2] + shift[count:, None, 2]).min(axis=1)
    shift[count:, 2] += np.maximum(clearance(free) - height, 0.0)
    planted = np.zeros((len(ankle), 3))
    planted[order] = ankle + shift
    return planted


def _settled(
    ends: Array, phase: Array, count: int, free: Array, pace: float, landing: int
) -> Array:
    """How to move a swinging foot, that it rises before it leaves and arrives before it lands.

    `ends` (PHASES, 2, 3) are heel and ball, `free` is 0 to 1 over the swing, which begins at
    moment `count`; `landing` is the end that touches down.
    """
    change = np.zeros((len(free), 2))
    leaving = int(ends[count - 1, :, 2].argmin())
    for end, stood, at, near in (
        (leaving, count - 1, phase[count - 1], free),
        (landing, 0, phase[0] + 1.0, 1.0 - free),
    ):
        still = np.tile(ends[stood, end, :2], (len(free), 1))
        still[:, 0] -= pace * (phase[count:] - at)
        weight = np.clip(1.0 - near / SETTLING, 0.0, 1.0)
        weight = weight * weight * (3 - 2 * weight)
        change += weight[:, None] * (still - ends[count:, end, :2])
    return change


def _lowered(excess: Array) -> Array:
    """A smooth change of height (PHASES,) that takes away where hips are too high by `excess`."""
    over = np.maximum(excess, 0.0)
    if not over.any():
        return over
    wide = np.max([np.roll(over, shift) for shift in range(-4, 5)], axis=0)
    kernel = np.hanning(11)[1:-1] / np.hanning(11).sum()
    smooth = sum(np.roll(wide, shift - 4) * weight for shift, weight in enumerate(kernel))
    return -np.asarray(smooth)
