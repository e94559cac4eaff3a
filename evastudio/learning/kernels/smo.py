"""SMO for epsilon-SVR with a Gaussian kernel: n variables, rows of the kernel matrix as needed.

Minimises 1/2 beta'K beta - y'beta + epsilon |beta|_1 over -C <= beta <= C with sum(beta) = 0, the
dual of Smola and Schoelkopf (A Tutorial on Support Vector Regression, 2004, eq. 10) with
beta = alpha - alpha*: half the variables of the usual form, and a kink in each at zero.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numba import njit
from numpy.typing import NDArray

from evastudio.learning.kernels.gaussian import in_blocks, kernel_row
from evastudio.learning.kernels.vectors import LANES
from evastudio.learning.kernels.working_set import FLATTEST, INFINITY, advance, choose

Doubles = NDArray[np.float64]
Numbers = NDArray[np.int64]
AWAY = -1
"""Slot of a row that is not in memory."""
LEAST_ROWS = 16
"""Rows kept in memory however little is allowed; a step needs two."""
MIN_TURN = 250
"""Steps between two looks at which variables can rest."""
NARROW = 0.8
"""Shorter rows are worth computing anew once at most this share of the variables moves."""

Watch = Callable[[float], None]
"""Is told the largest violation of optimality from time to time; may raise to stop."""


class Rows:
    """Rows of the kernel matrix of some points, computed when first asked for.

    They are kept in `memory` (float32); beyond that the one unused for longest makes room.
    """

    def __init__(
        self, points: NDArray[np.float32], gamma: float, memory: NDArray[np.float32]
    ) -> None:
        self.points = np.ascontiguousarray(points, dtype=np.float32)
        self.blocks = in_blocks(self.points)
        self.rate = np.float32(-gamma)
        self.count, self.size = self.points.shape
        self.width = -(-self.count // LANES) * LANES
        self.held = min(self.count, len(memory) // self.width)
        self.rows = memory[: self.held * self.width]
        self.slots = np.full(self.count, AWAY, np.int64)
        self.owners = np.full(self.held, AWAY, np.int64)
        self.stamps = np.zeros(self.held, np.int64)
        self.clock = np.zeros(2, np.int64)
        """How often a row was asked for, and how many slots are taken."""


def memory_for(count: int, megabytes: float) -> NDArray[np.float32]:
    """Memory for rows of `count` points or fewer, about `megabytes` but at least a few rows.

    What is never written is never taken from the system, so rows nobody asks for cost nothing.
    """
    width = -(-count // LANES) * LANES
    room = int(megabytes * 1e6 / (4 * width))
    return np.empty(min(count, max(LEAST_ROWS, room)) * width, np.float32)


@njit(cache=True, nogil=True)
def fetch(points, blocks, rows, slots, owners, stamps, clock, width, rate, number):
    """Where the kernel row of point `number` begins in `rows`; computes it if need be."""
    clock[0] += 1
    slot = slots[number]
    if slot < 0:
        if clock[1] < len(owners):
            slot = clock[1]
            clock[1] += 1
        else:
            slot = np.argmin(stamps)
            slots[owners[slot]] = AWAY
        owners[slot], slots[number] = number, slot
        row = rows[slot * width : (slot + 1) * width]
        kernel_row(points, number, blocks, points.shape[1], rate, row)
    stamps[slot] = clock[0]
    return slot * width


@njit(cache=True, nogil=True)
def bound(value, bound_at, epsilon):
    """The entries of `rise` and `fall` for a variable at `value`, see `working_set`."""
    rise = INFINITY if value >= bound_at else (epsilon if value >= 0.0 else -epsilon)
    fall = -INFINITY if value <= -bound_at else (epsilon if value > 0.0 else -epsilon)
    return rise, fall


@njit(cache=True, nogil=True)
def barriers(beta, bound_at, epsilon, rise, fall):
    """Fill `rise` and `fall` for all variables; what pads them can neither rise nor fall."""
    rise[:], fall[:] = INFINITY, -INFINITY
    for number in range(len(beta)):
        rise[number], fall[number] = bound(beta[number], bound_at, epsilon)


@njit(cache=True, nogil=True)
def length(slope, curvature, rising, falling, bound_at, epsilon):
    """How far to raise one variable and lower another: the exact minimum along that line.

    `slope` is the (negative) derivative at the start; it grows by `curvature`, and by twice
    epsilon where either variable passes zero.
    """
    end = min(bound_at - rising, falling + bound_at)
    first, second = INFINITY, INFINITY
    if rising < 0.0:
        first = -rising
    if falling > 0.0:
        second = falling
    if second < first:
        first, second = second, first
    for kink in (first, second):
        best = -slope / curvature
        if best <= kink or kink >= end:
            return min(best, end)
        slope += 2.0 * epsilon
        if slope + curvature * kink >= 0.0:
            return kink
    return min(-slope / curvature, end)


@njit(cache=True, nogil=True)
def descend(
    points, blocks, rows, slots, owners, stamps, clock, width, rate,
    beta, slopes, rise, fall, bound_at, epsilon, tolerance, steps,
):  # fmt: skip
    """Up to `steps` steps of SMO. Returns (steps taken, largest violation before the last)."""
    here = fetch(points, blocks, rows, slots, owners, stamps, clock, width, rate, 0)
    top, one = advance(rows, here, here, width, 0.0, slopes, rise)
    violation = INFINITY
    for step in range(steps):
        at_one = fetch(points, blocks, rows, slots, owners, stamps, clock, width, rate, one)
        violation, two = choose(rows, at_one, width, top, slopes, fall)
        if not violation > tolerance:
            return step, violation
        at_two = fetch(points, blocks, rows, slots, owners, stamps, clock, width, rate, two)
        slope = (slopes[two] - fall[two]) - top
        curvature = max(2.0 - 2.0 * np.float64(rows[at_one + two]), FLATTEST)
        far = length(slope, curvature, beta[one], beta[two], bound_at, epsilon)
        # Exactly zero or at the bound where the step ends there, whatever the sum rounds to.
        up, down = beta[one] + far, beta[two] - far
        up = bound_at if far == bound_at - beta[one] else (0.0 if far == -beta[one] else up)
        down = -bound_at if far == beta[two] + bound_at else (0.0 if far == beta[two] else down)
        beta[one], beta[two] = up, down
        rise[one], fall[one] = bound(up, bound_at, epsilon)
        rise[two], fall[two] = bound(down, bound_at, epsilon)
        top, one = advance(rows, at_one, at_two, width, far, slopes, rise)
    return steps, violation


@njit(cache=True, nogil=True)
def slopes_of(points, blocks, rows, slots, width, rate, targets, beta, slopes):
    """slopes = targets - K beta, from the rows in memory and others computed on the way."""
    count, size = points.shape
    slopes[:count] = targets
    slopes[count:] = 0.0
    spare = np.empty(width, np.float32)
    for number in range(count):
        weight = beta[number]
        if weight == 0.0:
            continue
        row = spare
        if slots[number] >= 0:
            row = rows[slots[number] * width : (slots[number] + 1) * width]
        else:
            kernel_row(points, number, blocks, size, rate, spare)
        for at in range(width):
            slopes[at] -= weight * np.float64(row[at])


class Descent:
    """One output's variables over the points of `rows`, on the way to the minimum."""

    def __init__(
        self, rows: Rows, targets: Doubles, beta: Doubles, bound_at: float, epsilon: float,
        slopes: Doubles | None = None,
    ) -> None:  # fmt: skip
        self.rows, self.targets, self.beta = rows, targets, beta
        self.bound_at, self.epsilon = bound_at, epsilon
        self.slopes, self.rise, self.fall = (np.empty(rows.width) for _ in range(3))
        if slopes is None:
            self.restore()
            return
        self.slopes[: rows.count], self.slopes[rows.count :] = slopes, 0.0
        barriers(beta, bound_at, epsilon, self.rise, self.fall)

    def restore(self) -> None:
        """Compute slopes and barriers anew from `beta`."""
        rows = self.rows
        barriers(self.beta, self.bound_at, self.epsilon, self.rise, self.fall)
        slopes_of(
            rows.points, rows.blocks, rows.rows, rows.slots, rows.width, rows.rate,
            self.targets, self.beta, self.slopes,
        )  # fmt: skip

    def descend(self, tolerance: float, steps: int) -> tuple[int, float]:
        """Up to `steps` steps. Returns (steps taken, largest violation before the last)."""
        rows = self.rows
        taken, violation = descend(
            rows.points, rows.blocks, rows.rows, rows.slots, rows.owners, rows.stamps, rows.clock,
            rows.width, rows.rate, self.beta, self.slopes, self.rise, self.fall,
            self.bound_at, self.epsilon, tolerance, steps,
        )  # fmt: skip
        return taken, violation

    def range(self) -> tuple[float, float]:
        """The most that a variable gains by rising, and the least that one loses by falling."""
        return float((self.slopes - self.rise).max()), float((self.slopes - self.fall).min())

    def open(self) -> NDArray[np.bool_]:
        """Which variables could still move: those strictly inside the present range rest."""
        top, bottom = self.range()
        count = self.rows.count
        ups = (self.slopes - self.rise)[:count]
        downs = (self.slopes - self.fall)[:count]
        return (ups >= bottom) | (downs <= top)

    def narrowed(self, kept: Numbers, memory: NDArray[np.float32]) -> Descent:
        """The same problem over the points `kept` alone, the others held where they are.

        Its slopes are handed over: they hold what the others contribute.
        """
        rows = Rows(self.rows.points[kept], -float(self.rows.rate), memory)
        return Descent(
            rows, self.targets[kept], self.beta[kept], self.bound_at, self.epsilon,
            self.slopes[kept],
        )  # fmt: skip


def minimise(
    whole: Descent,
    tolerance: float,
    most_steps: int,
    memory: NDArray[np.float32],
    watch: Watch,
) -> tuple[int, float]:
    """Bring `whole` to its minimum. Returns (steps taken, largest violation left).

    Variables that will stay at zero or at a bound are put aside as the end comes nearer
    (shrinking: Joachims 1998, as in LIBSVM's section 5.1), and the rest moves among shorter
    rows, held in `memory`; at the end all are looked at again.
    """
    part, kept = whole, np.arange(whole.rows.count)
    steps = 0
    while True:
        turn = max(MIN_TURN, part.rows.count // 8)
        taken, violation = part.descend(tolerance, min(turn, most_steps - steps))
        steps += taken
        watch(violation)
        done = violation <= tolerance or steps >= most_steps
        if part is not whole and done:
            whole.beta[kept] = part.beta
            part, kept = whole, np.arange(whole.rows.count)
            whole.restore()
            top, bottom = whole.range()
            violation = top - bottom
            done = violation <= tolerance or steps >= most_steps
        if done:
            return steps, violation
        awake = np.flatnonzero(part.open())
        if len(awake) <= NARROW * part.rows.count:
            if part is not whole:
                whole.beta[kept] = part.beta
            kept = kept[awake]
            part = part.narrowed(awake, memory)
