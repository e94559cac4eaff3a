"""The paper's table 3, with studies and votes."""

from __future__ import annotations

from evastudio.evaluation.preferences import Preference
from evastudio.evaluation.studies import Study
from evastudio.evaluation.table_three import table_three


def test_studies_stand_below_the_papers() -> None:
    assert table_three([])[-1] == "No study is stored yet."
    lines = table_three([Study("asteroids", "nobody, a test", 60.0, 90.0, "mine")])
    assert "| here | asteroids | nobody, a test | 1 min | 1.5 min | mine |" in lines
    assert len([line for line in lines if line.startswith("| the paper")]) == 6


def test_what_people_wrote_stays_in_its_cell() -> None:
    odd = Study("asteroids", "artist\n| the paper | x", None, 90.0, "mine | theirs\r\n")
    lines = table_three([odd])
    assert (
        lines[8] == r"| here | asteroids | artist \| the paper \| x |  | 1.5 min | mine \| theirs |"
    )


def test_votes_stand_below_with_their_interval() -> None:
    found = Preference(3, "crowd", ("shy", "scripted:shy"), (12, 3), 2, 4)
    lines = table_three([], [found])
    assert lines[-1] == "| crowd | shy | scripted:shy | 12 to 3 | 2 | 4 | 80 % (55 to 93) |"
    undecided = Preference(3, "crowd", ("shy", "scripted:shy"), (0, 0), 2, 1)
    assert table_three([], [undecided])[-1] == "| crowd | shy | scripted:shy | 0 to 0 | 2 | 1 |  |"
