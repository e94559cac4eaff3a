"""The examples run, each as its first lines say, against a studio that runs."""

from __future__ import annotations

import subprocess
import sys
from typing import TYPE_CHECKING

import pytest

from evastudio.workspace import shipped

if TYPE_CHECKING:
    from conftest import Studio

EXAMPLES = shipped() / "examples"
RUNS = {
    "demonstrate_and_play.py": ([], "crossed 10 of 10 fields"),
    "compare_policies.py": (["asteroids", "3"], "asteroids-careful"),
    "take_over.py": (["asteroids-careful"], "corrections"),
}


def test_every_example_is_run() -> None:
    assert {path.name for path in EXAMPLES.glob("*.py")} == set(RUNS)


@pytest.mark.parametrize("name", RUNS)
def test_an_example_does_what_it_says(studio: Studio, name: str) -> None:
    arguments, says = RUNS[name]
    done = subprocess.run(
        [sys.executable, str(EXAMPLES / name), studio.url, *arguments],
        capture_output=True,
        text=True,
        timeout=120,
    )
    assert done.returncode == 0, done.stderr
    assert says in done.stdout
