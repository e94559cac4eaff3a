"""Fitting again: what was fitted before stays, and what is told of it fits animators."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import evastudio
from evastudio.learning.finding import Finding
from evastudio.live.in_short import in_short
from evastudio.workspace import Workspace


def test_a_policy_beside_others_never_replaces_another(tmp_path: Path) -> None:
    workspace = Workspace(tmp_path / "work")
    evastudio.record(workspace, "asteroids", minutes=0.2, seed=4, session="Field")

    def fit(k: int, *, beside: bool = True, now: float = 0.0) -> str:
        told = evastudio.fit(
            workspace,
            "Field",
            learner="knn",
            settings={"k": k},
            delay="off",
            name="field",
            beside=beside,
            clock=lambda: now,
        )
        return str(told["policy"])

    first = workspace.policies / "field.safetensors"
    assert fit(3) == "field"
    data = first.read_bytes()
    assert fit(5) == "field-2"
    assert fit(7) == "field-3"
    assert fit(5, now=9.0) == "field-2"  # the same but for its date
    assert first.read_bytes() == data
    made_by = evastudio.load_policy(workspace.policies / "field-3.safetensors").made_by
    assert made_by.endswith("--out field-3.safetensors")
    assert fit(5, beside=False) == "field"
    assert first.read_bytes() != data


def test_a_finding_in_short_names_no_field() -> None:
    sentence = "32 % are unlike, most of all where “threat across” is -0.0935 to -0.0126."
    thin = Finding("thin", True, 0.32, sentence)
    assert in_short(thin).startswith("32 % of the moments are like nothing in your other takes: ")
    for name in ("thin", "copies", "hidden"):
        assert "threat" not in in_short(replace(thin, name=name))
    assert in_short(replace(thin, name="ambiguous")) == sentence
