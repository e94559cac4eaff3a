"""What was found, in words."""

from __future__ import annotations

import numpy as np

from evastudio.evaluation.results import Comparison, Evaluation
from evastudio.evaluation.words import in_words, label


def compared(**pilots: tuple[list[bool], list[float]]) -> str:
    """What is said of two pilots, by whether they ended well and how long they took."""
    found = {
        name: Evaluation(
            pilot=name,
            endings=("running", "crossed"),
            outcomes=np.array(good, dtype=np.int64),
            succeeded=np.array(good),
            figures={"time_s": np.array(times)},
        )
        for name, (good, times) in pilots.items()
    }
    (said,) = in_words(Comparison({"name": "field"}, 0, 40, found).to_json())
    return said


def test_a_difference_beyond_luck_is_called_one_and_says_for_whom() -> None:
    said = compared(a=([True] * 10 + [False] * 30, [30.0] * 40), b=([True] * 40, [28.0] * 40))
    assert said.startswith("b ends well more often than a: a in 25.0 % of the worlds, b in 100.0 %")
    assert said.endswith("In the same worlds, a needs more time (2 s).")


def test_what_may_be_luck_is_called_so() -> None:
    said = compared(a=([True] * 39 + [False], [30.0] * 40), b=([True] * 40, [30.0] * 40))
    assert "; of 40 worlds this may be luck, and more worlds would tell." in said
    assert "No other difference is larger than luck makes in 40 worlds." in said
    assert "equally often, in 100.0 %" in compared(
        a=([True] * 40, [30.0] * 40), b=([True] * 40, [30.0] * 40)
    )


def test_figures_of_a_scene_of_its_own_are_called_by_their_names() -> None:
    assert label("time_s") == "Time needed, s"
    assert label("stuck_s") == "Stuck, s"
    assert label("blocked_per_minute") == "Blocked per minute"
