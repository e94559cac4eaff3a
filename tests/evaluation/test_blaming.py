"""Faults of a user's scene are told in a sentence, wherever it is evaluated."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

import evastudio
from evastudio.errors import InvalidInputError
from evastudio.evaluation.blaming import blaming
from evastudio.workspace import Workspace
from evastudio.world.scene import Scene

WALKER = Path(__file__).parent.parent / "scenes" / "walker.py"
FAULTS = {
    "raise": ("        return {}['pace']", "KeyError: 'pace'"),
    "shape": ("        return snapshot.after(cell=snapshot['cell'][:, :1])", "Error"),
}


def faulty(workspace: Workspace, fault: str) -> int:
    """Write a scene whose step does not work; the line of the fault."""
    text = WALKER.read_text(encoding="utf-8").replace('"walker"', '"mine"')
    head, found, rest = text.partition("    def step(")
    signature, _, body = rest.partition(":\n")
    folder = workspace.root / "scenes"
    folder.mkdir()
    whole = f"{head}{found}{signature}:\n{fault}\n{body}"
    (folder / "mine.py").write_text(whole, encoding="utf-8")
    return whole[: whole.index(fault)].count("\n") + 1


@pytest.mark.parametrize("jobs", [1, 2])
def test_a_scene_that_raises_is_named_with_its_line(workspace: Workspace, jobs: int) -> None:
    fault, says = FAULTS["raise"]
    line = faulty(workspace, fault)
    with pytest.raises(InvalidInputError) as caught:
        evastudio.evaluate(workspace, ["straight"], scene="mine", worlds=2, jobs=jobs)
    said = str(caught.value)
    assert said.startswith(f"Scene 'mine' failed while 'straight' acted in it: {says} (")
    assert f"mine.py, line {line})" in said
    assert evastudio.evaluations(workspace) == []


def test_a_scene_that_gives_what_cannot_be_worked_with_is_named_too(workspace: Workspace) -> None:
    fault, says = FAULTS["shape"]
    faulty(workspace, fault)
    with pytest.raises(InvalidInputError, match=f"Scene 'mine' failed .*{says}"):
        evastudio.evaluate(workspace, ["straight"], scene="mine", worlds=2)


def test_a_fault_of_the_studio_stays_what_it_is(asteroids: Callable[..., Scene]) -> None:
    with pytest.raises(ZeroDivisionError), blaming(asteroids(), "straight"):
        _ = 1 / 0
