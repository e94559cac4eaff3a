"""Held keys to actions: ramps, exact to the moment a key went down."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from evastudio.world.scene import Control
from evastudio.world.spaces import Array, Space, Symbols


@dataclass
class _Axis:
    """One control: what its keys ask for, over time, and how far it has followed."""

    control: Control
    deflection: float = 0.0
    """-1 to 1 at the end of the last interval read."""
    target: float = 0.0
    """Where the keys push it at that moment."""
    since: float = -np.inf
    """When they began to push it there, of the time that was read."""
    until: float = -np.inf
    """Where the last interval read ended."""
    changes: list[tuple[float, float, float]] = field(default_factory=list)
    """Later (time, target, shortest time of the push before), in order."""

    def ask(self, at: float, target: float, hold_s: float) -> None:
        """From `at` on the keys push towards `target`; a push before it lasts at least `hold_s`."""
        if target != (self.changes[-1][1] if self.changes else self.target):
            self.changes.append((at, target, hold_s))

    def read(self, start: float, end: float) -> float:
        """Mean deflection over the interval, which follows the one read before.

        Of a latched control the deflection at its end: a push that lasts a step is still on then.
        What changed in time that nobody reads, while the clock stood, counts from `start` on.
        """
        if np.isfinite(self.until):
            self.since += max(start - self.until, 0.0)
        self.until = end
        area, now = 0.0, start
        while self.changes:
            at, target, hold_s = self.changes[0]
            at = max(at, now, self.since + hold_s if self.target else now)
            if at >= end:
                break
            del self.changes[0]
            area += self._move(at - now)
            now, self.target, self.since = at, target, at
        area += self._move(end - now)
        return self.deflection if self.control.latched else area / (end - start)

    def _move(self, duration: float) -> float:
        """Follow the target for `duration` seconds; the area under the deflection."""
        ramp = self.control.ramp_s
        distance = self.target - self.deflection
        moving = min(duration, abs(distance) * ramp)
        reached = self.deflection + (np.sign(distance) * moving / ramp if ramp else distance)
        if moving >= abs(distance) * ramp:
            reached = self.target
        area = (self.deflection + reached) / 2 * moving + reached * (duration - moving)
        self.deflection = float(reached)
        return float(area)


class HeldKeys:
    """The keys a person holds, read once for each decision step.

    Times are seconds of one clock. An edge that arrives late counts from the next reading on;
    a press shorter than a decision step counts as one step.
    """

    def __init__(self, controls: Sequence[Control], action: Space, dt_s: float) -> None:
        self._action = action
        self._dt_s = dt_s
        self._axes = [_Axis(control) for control in controls]
        self._known = {
            code for control in controls for code in (*control.negative, *control.positive)
        }
        self._read_until = -np.inf
        self.held: frozenset[str] = frozenset()

    def steers(self, codes: Iterable[str]) -> bool:
        """Whether any of these keys moves the character."""
        return not self._known.isdisjoint(codes)

    def hold(self, codes: Iterable[str], at: float) -> None:
        """From `at` on exactly these keys are held; codes that move nothing are ignored."""
        self.held = frozenset(codes) & self._known
        at = max(at, self._read_until)
        for axis in self._axes:
            target = float(any(code in self.held for code in axis.control.positive)) - float(
                any(code in self.held for code in axis.control.negative)
            )
            axis.ask(at, target * axis.control.reach, self._dt_s)

    def center(self) -> None:
        """Forget every key and every deflection."""
        self.held = frozenset()
        for axis in self._axes:
            axis.deflection, axis.target = 0.0, 0.0
            axis.changes.clear()

    def read(self, start: float, end: float) -> Array:
        """The action for a step of the time from `start` to `end`, shape (1, action size).

        Components that no control moves are zero, or the bound nearest to it. Of symbols it is
        the one whose keys were held most of the time, or the first.
        """
        self._read_until = end
        return self._action_of(self._axes, start, end)

    def foresee(self, start: float, end: float) -> Array:
        """What `read` would return if no key changed until then; nothing is read yet."""
        axes = [replace(axis, changes=list(axis.changes)) for axis in self._axes]
        return self._action_of(axes, start, end)

    def _action_of(self, axes: Sequence[_Axis], start: float, end: float) -> Array:
        if isinstance(self._action, Symbols):
            held = np.zeros(len(self._action.names))
            for axis in axes:
                held[self._action.names.index(axis.control.field)] += axis.read(start, end)
            return np.array([[float(held.argmax())]])
        action = np.clip(np.zeros(self._action.size), self._action.low, self._action.high)
        for axis in axes:
            share = axis.read(start, end)
            column = self._action.names.index(axis.control.field)
            bound = self._action.high if share > 0 else -self._action.low
            action[column] = share * bound[column]
        return action[None, :]
