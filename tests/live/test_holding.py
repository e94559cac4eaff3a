"""Who holds what, of several who steer one stage."""

from __future__ import annotations

from evastudio.live.holding import Holding


def test_all_hands_count_until_each_lets_go() -> None:
    holding = Holding()
    holding.hold("one", ["KeyA"], {"turn": 0.5})
    holding.hold("other", ["KeyW", "KeyA"], {"turn": 0.25, "climb": -1.0})
    assert holding.codes == {"KeyA", "KeyW"}
    assert holding.pushed == {"turn": 0.75, "climb": -1.0}
    holding.hold("other", [], {})
    assert (holding.codes, holding.pushed) == ({"KeyA"}, {"turn": 0.5})


def test_what_one_holds_replaces_what_they_held() -> None:
    holding = Holding()
    holding.hold("one", ["KeyA"], {"turn": 0.5})
    holding.hold("one", ["KeyD"], {})
    assert (holding.codes, holding.pushed) == ({"KeyD"}, {})


def test_after_letting_go_nothing_is_held() -> None:
    holding = Holding()
    holding.hold("one", ["KeyA"], {"turn": 0.5})
    holding.let_go()
    assert (holding.codes, holding.pushed) == (frozenset(), {})
