"""Held keys and pushed sticks to actions: ramps, exact to the moment a key went down."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from evastudio.errors import InvalidInputError
from evastudio.world.scene import Control
from evastudio.world.spaces import Array, Space, Symbols

SENSITIVITIES = (0.1, 2.0)
RAMPS = (0.0, 3.0)


@dataclass(frozen=True)
class Feel:
    """How a character answers a hand. Raises InvalidInputError out of its bounds."""

    sensitivity: float = 1.0
    """How far a held key or a stick at its end goes, in shares of the control's own reach; no
    control goes further than its full deflection."""
    ramp: float = 1.0
    """How long a held key takes to get there, in shares of the control's own ramp. A stick follows
    the hand at once, which is its own ramp."""

    def __post_init__(self) -> None:
        bounds = {"sensitivity": SENSITIVITIES, "ramp": RAMPS}
        for name, (low, high) in bounds.items():
            value = getattr(self, name)
            if not low <= value <= high:
                raise InvalidInputError(
                    f"The {name} is {value:g}; it must be from {low:g} to {high:g}."
                )


@dataclass
class _Axis:
    """What the keys of a control, or a stick, ask for over time, and how far it has followed."""

    latched: bool
    ramp_s: float
    deflection: float = 0.0
    """-1 to 1 at the end of the last interval read."""
    target: float = 0.0
    """Where it is pushed at that moment."""
    since: float = -math.inf
    """Since when, of the time that was read."""
    until: float = -math.inf
    """Where the last interval read ended."""
    changes: list[tuple[float, float, float]] = field(default_factory=list)
    """Later (time, target, shortest time of the push before), in order."""

    def ask(self, at: float, target: float, hold_s: float) -> None:
        """From `at` on it is pushed towards `target`; a push before it lasts at least `hold_s`."""
        if target != (self.changes[-1][1] if self.changes else self.target):
            self.changes.append((at, target, hold_s))

    def read(self, start: float, end: float) -> float:
        """Mean deflection over the interval, which follows the one read before.

        Of a latched control the deflection at its end: a push that lasts a step is still on then.
        What changed in time that nobody reads, while the clock stood, counts from `start` on.
        """
        if math.isfinite(self.until):
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
        return self.deflection if self.latched else area / (end - start)

    def _move(self, duration: float) -> float:
        """Follow the target for `duration` seconds; the area under the deflection."""
        ramp = self.ramp_s
        distance = self.target - self.deflection
        moving = min(duration, abs(distance) * ramp)
        reached = self.target
        if moving < abs(distance) * ramp:
            reached = self.deflection + math.copysign(moving / ramp, distance)
        area = (self.deflection + reached) / 2 * moving + reached * (duration - moving)
        self.deflection = reached
        return area


class HeldKeys:
    """The keys a person holds and the sticks they push, read once for each decision step.

    Times are seconds of one clock. An edge that arrives late counts from the next reading on;
    a press shorter than a decision step counts as one step.
    """

    def __init__(
        self, controls: Sequence[Control], action: Space, dt_s: float, feel: Feel | None = None
    ) -> None:
        self._controls = tuple(controls)
        self._action = action
        self._dt_s = dt_s
        self._axes = [_Axis(control.latched, control.ramp_s) for control in controls]
        self._sticks = [_Axis(control.latched, 0.0) for control in controls]
        self.suit(feel or Feel())
        self._columns = [action.names.index(control.field) for control in controls]
        self._rest = np.clip(np.zeros(action.size), action.low, action.high)
        """What is done where nothing is held."""
        self._known = {
            code for control in controls for code in (*control.negative, *control.positive)
        }
        self._read_until = -math.inf
        self.held: frozenset[str] = frozenset()

    def steers(self, codes: Iterable[str], pushed: Mapping[str, float] | None = None) -> bool:
        """Whether any of these keys moves the character, or a stick that is pushed past half."""
        fields = {control.field for control in self._controls}
        far = {field for field, share in (pushed or {}).items() if abs(share) > 0.5}
        return not self._known.isdisjoint(codes) or not fields.isdisjoint(far)

    def suit(self, feel: Feel) -> None:
        """Answer like that, to keys pressed and sticks moved from now on."""
        self._feel = feel
        for axis, control in zip(self._axes, self._controls, strict=True):
            axis.ramp_s = control.ramp_s * feel.ramp

    def hold(
        self, codes: Iterable[str], at: float, pushed: Mapping[str, float] | None = None
    ) -> None:
        """From `at` on exactly these keys are held, and sticks pushed so far.

        `pushed` is from -1 to 1 by the field of a control; where a key is held too, both add up.
        Codes and fields that move nothing are ignored.
        """
        self.held = frozenset(codes) & self._known
        at = max(at, self._read_until)
        given = pushed or {}
        for axis, stick, control in zip(self._axes, self._sticks, self._controls, strict=True):
            reach = min(control.reach * self._feel.sensitivity, 1.0)
            held = float(any(code in self.held for code in control.positive)) - float(
                any(code in self.held for code in control.negative)
            )
            axis.ask(at, held * reach, self._dt_s)
            # Only letting go waits: a hand moves a stick more often than decisions fall.
            share = min(max(given.get(control.field, 0.0), -1.0), 1.0)
            stick.ask(at, share * reach, 0.0 if share else self._dt_s)

    def center(self) -> None:
        """Forget every key, every stick and every deflection."""
        self.held = frozenset()
        for axis in (*self._axes, *self._sticks):
            axis.deflection, axis.target = 0.0, 0.0
            axis.changes.clear()

    def read(self, start: float, end: float) -> Array:
        """The action for a step of the time from `start` to `end`, shape (1, action size).

        Components that no control moves are zero, or the bound nearest to it. Of symbols it is
        the one whose keys were held most of the time, or the first.
        """
        self._read_until = end
        return self._action_of(self._axes, self._sticks, start, end)

    def foresee(self, start: float, end: float) -> Array:
        """What `read` would return if no key changed until then; nothing is read yet."""
        axes, sticks = (
            [replace(axis, changes=list(axis.changes)) for axis in some]
            for some in (self._axes, self._sticks)
        )
        return self._action_of(axes, sticks, start, end)

    def _action_of(
        self, axes: Sequence[_Axis], sticks: Sequence[_Axis], start: float, end: float
    ) -> Array:
        shares = [
            min(max(axis.read(start, end) + stick.read(start, end), -1.0), 1.0)
            for axis, stick in zip(axes, sticks, strict=True)
        ]
        if isinstance(self._action, Symbols):
            held = np.zeros(len(self._action.names))
            for column, share in zip(self._columns, shares, strict=True):
                held[column] += share
            return np.array([[float(held.argmax())]])
        action, space = self._rest.copy(), self._action
        for column, share in zip(self._columns, shares, strict=True):
            bound = space.high[column] if share > 0 else -space.low[column]
            action[column] = share * bound
        return action[None, :]
