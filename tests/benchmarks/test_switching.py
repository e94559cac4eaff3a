"""Switches learned from ten marked demonstrations fall where the rule has them, unseen."""

from __future__ import annotations

import pytest

from benchmarks.switching import Rule, measured
from evastudio.workspace import shipped
from evastudio.world.loading import load_scene_file

CROWD = load_scene_file(shipped() / "scenes" / "crowd.py")
RULES = (
    Rule("the impact", "event:impact", "scripted:surprised"),
    Rule("a time", "after:12s", "scripted:surprised", "crowd-shy"),
    Rule("a region", "once region:-1,-1,3.1,12", "scripted:hurried", "crowd-shy"),
    Rule("a distance", "once event:impact and boulder>12", "scripted:surprised"),
)


@pytest.mark.parametrize("rule", RULES, ids=lambda rule: rule.words)
def test_it_falls_within_one_decision_of_the_rule_in_nearly_all_unseen_runs(rule: Rule) -> None:
    scene = CROWD(people=10, side=14, length=40)
    assert measured(scene, rule, 50)["near"] >= 0.95
