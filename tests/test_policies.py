"""Shipped policies fly, and the commands they carry make them again."""

from __future__ import annotations

import shlex
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import pytest

from benchmarks.remaking import apart
from evastudio.learning.policy_files import load_policy
from evastudio.learning.switch import load_switch
from evastudio.workspace import Workspace, shipped

POLICIES = sorted((shipped() / "policies").glob("*.safetensors"))
SCRIPTED = [path for path in POLICIES if load_policy(path).made_by.startswith("evastudio record")]
"""Those that anybody can make again; `make bench-street` does for those learned from recordings,
which are not in the repository."""
SWITCHES = sorted((shipped() / "policies").glob("*.switch.json"))


def test_there_is_one_for_every_scene() -> None:
    scenes = {path.stem for path in (shipped() / "scenes").glob("*.py")}
    assert scenes == {load_policy(path).scene_name for path in POLICIES}


def test_those_that_only_recordings_make_again_are_known() -> None:
    assert {path.stem for path in POLICIES} - {path.stem for path in SCRIPTED} == {"street-people"}


@pytest.mark.parametrize("path", SCRIPTED, ids=lambda path: path.stem)
def test_its_own_commands_make_it_again(path: Path, tmp_path: Path) -> None:
    assert apart(path, tmp_path) < 0.005


@pytest.mark.parametrize("path", SWITCHES, ids=lambda path: path.name)
def test_a_switch_is_made_again_by_its_own_command(path: Path, tmp_path: Path) -> None:
    made = load_switch(path)
    program, *words = shlex.split(made.made_by)
    assert program == "evastudio"
    subprocess.run(
        [sys.executable, "-m", "evastudio", *words, "--workspace", "."],
        check=True,
        cwd=tmp_path,
        capture_output=True,
    )
    again = load_switch(tmp_path / "policies" / path.name)
    assert replace(again, created=made.created) == made


@pytest.mark.parametrize("path", POLICIES, ids=lambda path: path.stem)
def test_it_does_well_where_it_has_never_been(path: Path, workspace: Workspace) -> None:
    import evastudio

    scene = load_policy(path).scene_name
    worlds = 100 if scene == "asteroids" else 5
    result = evastudio.evaluate(workspace, [path.stem], worlds=worlds, seed=424242)
    assert result["policies"][path.stem]["succeeded"] >= 0.97 * worlds
