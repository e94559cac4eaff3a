"""A pace: how many messages somebody may send, on average and at once."""

from __future__ import annotations


class Pace:
    """A bucket that fills at `per_s` and holds `at_once`; each message takes one out."""

    def __init__(self, per_s: float, at_once: float) -> None:
        self._per_s = per_s
        self._at_once = at_once
        self._left = at_once
        self._at_s: float | None = None

    def allows(self, now_s: float) -> bool:
        """Whether one more may come now, on a monotonic clock."""
        passed_s = 0.0 if self._at_s is None else now_s - self._at_s
        self._at_s = now_s
        self._left = min(self._at_once, self._left + passed_s * self._per_s)
        if self._left < 1.0:
            return False
        self._left -= 1.0
        return True
