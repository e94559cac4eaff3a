"""A throttle for guesses at tokens, per address. Its memory is bounded."""

from __future__ import annotations

import ipaddress
from collections import OrderedDict, deque
from dataclasses import dataclass, field

FREE = 20
"""Different wrong tokens that an address may try at once."""
REFILL_S = 3.0
"""After so long it may try one more."""
MOST_ADDRESSES = 4096
REMEMBERED = 16
"""The latest wrong tokens of an address; showing one of them again is no new guess."""
MOST_KNOWN = 1024


@dataclass
class _Guesses:
    spent: float = 0.0
    at_s: float = 0.0
    latest: deque[str] = field(default_factory=lambda: deque(maxlen=REMEMBERED))


class Throttle:
    """Lets each address make few guesses, and everybody who was let in before go on.

    Times are of a monotonic clock, tokens are told by their digests.
    """

    def __init__(self) -> None:
        self._guesses: OrderedDict[str, _Guesses] = OrderedDict()
        self._known: OrderedDict[str, None] = OrderedDict()

    def wait_s(self, address: str, digest: str, now_s: float) -> float:
        """How long until that address may show that token; 0 where it may now."""
        found = self._guesses.get(_net(address))
        if found is None or digest in self._known or digest in found.latest:
            return 0.0
        excess = _spent(found, now_s) + 1.0 - FREE
        return max(0.0, excess * REFILL_S)

    def right(self, digest: str) -> None:
        """A token was right: whoever shows it again is not slowed down by others' guesses."""
        self._known[digest] = None
        self._known.move_to_end(digest)
        while len(self._known) > MOST_KNOWN:
            self._known.popitem(last=False)

    def wrong(self, address: str, digest: str, now_s: float) -> None:
        """A token was wrong."""
        self._known.pop(digest, None)
        net = _net(address)
        found = self._guesses.setdefault(net, _Guesses(at_s=now_s))
        self._guesses.move_to_end(net)
        if digest not in found.latest:
            found.spent, found.at_s = _spent(found, now_s) + 1.0, now_s
            found.latest.append(digest)
        while len(self._guesses) > MOST_ADDRESSES:
            self._guesses.popitem(last=False)


def _spent(found: _Guesses, now_s: float) -> float:
    return max(0.0, found.spent - (now_s - found.at_s) / REFILL_S)


def _net(address: str) -> str:
    """What one guesser has for sure: an IPv4 address, or the half of an IPv6 one."""
    try:
        parsed = ipaddress.ip_address(address)
    except ValueError:
        return address[:100]
    if parsed.version == 4:
        return address
    return str(ipaddress.ip_network((parsed, 64), strict=False))
