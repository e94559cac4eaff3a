"""Who holds which keys and pushes which sticks: several pages may steer one stage."""

from __future__ import annotations

from collections.abc import Iterable, Mapping


class Holding:
    """What each of them holds, and all of them together."""

    def __init__(self) -> None:
        self._by: dict[object, tuple[frozenset[str], dict[str, float]]] = {}

    def hold(self, by: object, codes: Iterable[str], pushed: Mapping[str, float]) -> None:
        """`by` holds exactly these keys from now on, and pushes sticks so far."""
        self._by.pop(by, None)
        held, far = frozenset(codes), dict(pushed)
        if held or far:
            self._by[by] = held, far

    def let_go(self) -> None:
        """Nobody holds anything any more."""
        self._by.clear()

    @property
    def codes(self) -> frozenset[str]:
        """Every key that somebody holds."""
        return frozenset[str]().union(*(codes for codes, _ in self._by.values()))

    @property
    def pushed(self) -> dict[str, float]:
        """How far each control is pushed by all sticks together, which may be beyond its end."""
        together: dict[str, float] = {}
        for _, sticks in self._by.values():
            for field, share in sticks.items():
                together[field] = together.get(field, 0.0) + share
        return together
