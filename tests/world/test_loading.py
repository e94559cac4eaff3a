"""Scenes are found by path, and files that are none say why."""

from __future__ import annotations

import pickle
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from evastudio.errors import InvalidInputError, NotFoundError
from evastudio.workspace import Workspace, shipped
from evastudio.world.check import check_file, check_scene
from evastudio.world.loading import find_scene, find_scenes, load_scene_file

SHIPPED = shipped() / "scenes"


def test_shipped_scenes_are_found() -> None:
    assert "asteroids" in find_scenes([SHIPPED])


def test_a_users_scene_hides_the_shipped_one_of_that_name(workspace: Workspace) -> None:
    own = workspace.root / "scenes"
    own.mkdir()
    text = (SHIPPED / "asteroids.py").read_text().replace("Asteroid field", "My own field")
    (own / "mine.py").write_text(text)
    assert find_scene("asteroids", workspace.scene_folders).title == "My own field"


def test_an_unknown_scene_names_the_known() -> None:
    with pytest.raises(NotFoundError, match="Did you mean 'asteroids'"):
        find_scene("asteriods", [SHIPPED])


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("x = 1\n", "defines 0 scenes"),
        ("import nothing_like_this\n", "does not run: ModuleNotFoundError"),
        ("SCENE = 3\n", "must be a subclass of Scene"),
        ("def broken(:\n", "SyntaxError"),
    ],
)
def test_a_file_that_is_no_scene_says_why(tmp_path: Path, text: str, says: str) -> None:
    path = tmp_path / "scene.py"
    path.write_text(text)
    with pytest.raises(InvalidInputError, match=says):
        load_scene_file(path)
    assert find_scenes([tmp_path]) == {}


def test_a_changed_file_is_loaded_anew(tmp_path: Path) -> None:
    path = tmp_path / "scene.py"
    text = (SHIPPED / "asteroids.py").read_text()
    path.write_text(text)
    first = load_scene_file(path)
    assert load_scene_file(path) is first
    path.write_text(text.replace("Asteroid field", "Another"))
    assert load_scene_file(path).title == "Another"


def test_an_unknown_scene_names_the_files_that_could_not_be_used(tmp_path: Path) -> None:
    (tmp_path / "mine.py").write_text("def broken(:\n")
    with pytest.raises(NotFoundError, match=r"mine\.py.*SyntaxError"):
        find_scene("mine", [tmp_path])


def test_a_missing_file_is_not_found(tmp_path: Path) -> None:
    with pytest.raises(NotFoundError, match="no scene file"):
        check_file(tmp_path / "none.py")


@pytest.mark.parametrize(
    ("change", "into", "rule"),
    [
        ("+ directions(heading)", "+ np.random.rand() + directions(heading)", "repeats exactly"),
        ("turn=heading - before,", "turn=heading * np.nan,", "finite"),
        (
            'before = snapshot["heading"]',
            'before = snapshot["heading"]\n        before += 0.01',
            "leaves its snapshot alone",
        ),
        (
            'steps=snapshot["steps"] + 1,',
            'steps=snapshot["steps"] + snapshot.worlds,',
            "batched equals one by one",
        ),
        (
            "return Percept(self.state.clip(states), frame)",
            "return Percept(states - 9.0, frame)",
            "perceptions fit",
        ),
        ('Control("theta", ', 'Control("thtea", ', "declares"),
    ],
)
def test_the_conformance_suite_finds_what_is_broken(
    tmp_path: Path, change: str, into: str, rule: str
) -> None:
    text = (SHIPPED / "asteroids.py").read_text()
    assert change in text
    path = tmp_path / "scene.py"
    path.write_text(text.replace(change, into))
    broken = [found.rule for found in check_scene(load_scene_file(path)) if found.problem]
    assert any(rule in one for one in broken)


def test_a_scene_travels_by_value(tmp_path: Path) -> None:
    """To a process that never saw its file."""
    path = tmp_path / "scene.py"
    path.write_text((SHIPPED / "asteroids.py").read_text())
    scene = load_scene_file(path)(density=2.5)
    sent = pickle.dumps(scene)
    path.unlink()
    code = """
import pickle, sys
scene = pickle.load(sys.stdin.buffer)
sys.stdout.buffer.write(pickle.dumps((scene.identity(), scene.worlds([3])["rocks"])))
"""
    done = subprocess.run([sys.executable, "-c", code], input=sent, stdout=-1, check=True)
    identity, rocks = pickle.loads(done.stdout)
    assert identity == scene.identity()
    assert np.array_equal(rocks, scene.worlds([3])["rocks"])
