"""A user's clips: dropped into a folder, listed, and chosen for activities."""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
import pytest

from evastudio.errors import InvalidInputError, NotFoundError, StorageError
from evastudio.motion.figures import Figures
from evastudio.motion.library import CHOICES, Choice, Library
from evastudio.motion.moment import Activity
from evastudio.workspace import Workspace
from tests.motion.walker import bvh, described, glb, packed, walking


@pytest.fixture
def library(tmp_path: Path) -> Library:
    folder = Workspace(tmp_path).motion
    folder.mkdir()
    (folder / "hero.glb").write_bytes(glb(walking(1.2)))
    (folder / "stroll.bvh").write_text(bvh(walking(0.8, moves=False)))
    (folder / "broken.bvh").write_text("HIERARCHY")
    (folder / "readme.txt").write_text("not a clip")
    (folder / "no\udcffletter.bvh").write_text("HIERARCHY")
    return Library(folder)


def test_files_are_listed_with_their_clips_or_their_problem(library: Library) -> None:
    broken, hero, stroll = library.files()
    assert (hero.name, hero.clips, hero.problem) == ("hero.glb", ("walk",), None)
    assert (stroll.name, stroll.clips, stroll.problem) == ("stroll.bvh", ("stroll",), None)
    assert broken.clips == ()
    assert broken.problem is not None
    assert "no BVH file" in broken.problem


def test_a_workspace_without_the_folder_moves_as_shipped(tmp_path: Path) -> None:
    library = Library(tmp_path / "motion")
    assert library.files() == []
    assert library.choices() == {}
    assert float(library.figures().cadence(1.2)) == float(Figures().cadence(1.2))


def test_a_chosen_clip_is_walked_and_can_be_forgotten(library: Library) -> None:
    library.choose("walk", "stroll.bvh", "stroll")
    library.choose("stagger", "hero.glb", "walk")
    assert Library(library.folder).choices() == {
        Activity.WALK: Choice("stroll.bvh", "stroll"),
        Activity.STAGGER: Choice("hero.glb", "walk"),
    }
    figures = library.figures()
    assert figures.length_s(Activity.STAGGER) == pytest.approx(2.4, abs=0.05)
    assert float(figures.cadence(1.2)) != float(Figures().cadence(1.2))
    library.forget("walk")
    assert set(library.choices()) == {Activity.STAGGER}
    assert not list(library.folder.glob("*.part"))


def test_a_file_is_added_in_place_of_an_older_one(library: Library) -> None:
    fresh = bvh(walking(0.8, 1.5)).encode()
    added = library.add("stroll.bvh", fresh)
    assert (added.clips, added.problem) == (("stroll",), None)
    assert (library.folder / "stroll.bvh").read_bytes() == fresh


@pytest.mark.parametrize("name", ["../x.bvh", "x/y.bvh", ".x.bvh", "x.exe", "", CHOICES, "x\0.bvh"])
def test_only_names_of_clips_are_added(library: Library, name: str) -> None:
    with pytest.raises(InvalidInputError, match="no name for a file of clips"):
        library.add(name, bvh(walking(1.2)).encode())


def test_what_cannot_be_played_any_more_moves_as_shipped(library: Library) -> None:
    library.choose("walk", "stroll.bvh", "stroll")
    library.choose("stagger", "hero.glb", "walk")
    (library.folder / "stroll.bvh").write_text("HIERARCHY")
    figures, problems = library.playable()
    assert set(problems) == {Activity.WALK}
    assert "no BVH file" in problems[Activity.WALK]
    assert figures.length_s(Activity.STAGGER) == pytest.approx(2.4, abs=0.05)
    assert figures is library.playable()[0]


def test_a_file_that_has_changed_is_read_anew(library: Library) -> None:
    first = library.clip("stroll.bvh", "stroll")
    path = library.folder / "stroll.bvh"
    path.write_text(bvh(walking(0.8, 1.5)))
    assert not np.array_equal(library.clip("stroll.bvh", "stroll").rotations, first.rotations)


@pytest.mark.parametrize(
    ("activity", "file", "clip", "match"),
    [
        ("wlak", "hero.glb", "walk", "Did you mean 'walk'"),
        ("turn", "hero.glb", "walk", "no activity 'turn'"),
        ("walk", "heros.glb", "walk", "Did you mean 'hero.glb'"),
        ("walk", "hero.glb", "run", "no clip 'run' in 'hero.glb'"),
        ("walk", "../motion/hero.glb", "walk", "no file of clips"),
        ("walk", "readme.txt", "readme", "no file of clips"),
    ],
)
def test_what_is_not_there_cannot_be_chosen(
    library: Library, activity: str, file: str, clip: str, match: str
) -> None:
    with pytest.raises(NotFoundError, match=match):
        library.choose(activity, file, clip)
    assert library.choices() == {}


def test_what_does_not_fit_cannot_be_chosen(library: Library) -> None:
    with pytest.raises(InvalidInputError, match="no BVH file"):
        library.choose("walk", "broken.bvh", "broken")
    assert library.choices() == {}


@pytest.mark.parametrize(
    "text",
    [
        "{",
        "[]",
        '{"walk": 5}',
        '{"fly": {"file": "a", "clip": "b"}}',
        '{"walk": {"file": "\\ud800.glb", "clip": "b"}}',
    ],
)
def test_a_damaged_file_of_choices_is_told(library: Library, text: str) -> None:
    (library.folder / CHOICES).write_text(text)
    with pytest.raises(StorageError, match="delete it to begin with the shipped"):
        library.figures()


def test_a_choice_whose_file_has_gone_is_told(library: Library) -> None:
    library.choose("walk", "hero.glb", "walk")
    (library.folder / "hero.glb").unlink()
    with pytest.raises(NotFoundError, match=r"hero\.glb"):
        library.figures()


def test_choices_are_a_small_file_for_people(library: Library) -> None:
    library.choose("run", "hero.glb", "walk")
    told = json.loads((library.folder / CHOICES).read_text())
    assert told == {"run": {"file": "hero.glb", "clip": "walk"}}


def test_a_folder_that_cannot_be_written_is_told(tmp_path: Path) -> None:
    (tmp_path / "motion").write_text("in the way")
    with pytest.raises(StorageError, match="could not be written"):
        Library(tmp_path / "motion").forget("walk")


def test_the_examples_in_the_document_run(tmp_path: Path) -> None:
    told, data = described(walking(1.2))
    told["animations"][0]["name"] = "Walking_A"
    (tmp_path / "motion").mkdir()
    (tmp_path / "motion" / "hero.glb").write_bytes(packed(told, data))
    document = Path(__file__).parents[2] / "docs" / "motion.md"
    examples = re.findall(r"```python\n(.*?)```", document.read_text(), re.DOTALL)
    assert len(examples) == 2
    for example in examples:
        exec(example, {"folder": tmp_path})
