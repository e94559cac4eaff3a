"""Pictures of stored evaluations: drawn once, kept, and never of something else."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

import evastudio
from evastudio.demonstrations.store import Store
from evastudio.errors import NotFoundError, StorageError
from evastudio.live.picturing import draw_pictures, kept_pictures, picture_file
from evastudio.pilots.pegasus import Pegasus
from evastudio.workspace import Workspace


@pytest.fixture
def store(workspace: Workspace) -> Iterator[Store]:
    """That of the workspace, which evaluations are kept in."""
    with Store(workspace.store_url) as opened:
        yield opened


def evaluated(workspace: Workspace, density: float, *names: str) -> int:
    told = evastudio.evaluate(workspace, names, worlds=3, seed=2, options={"density": density})
    return int(told["evaluation"])


def test_pictures_are_drawn_once_to_the_same_bytes(workspace: Workspace, store: Store) -> None:
    number = evaluated(workspace, 1.0, "straight")
    assert kept_pictures(workspace, store, number).names == ()
    drawn = draw_pictures(workspace, number)
    kept = kept_pictures(workspace, store, number)
    assert kept.whole
    assert kept.left_out is None
    assert (
        list(kept.names) == drawn["pictures"] == ["outcomes", "paths", "paths-in-space", "actions"]
    )
    files = [
        picture_file(workspace, store, number, f"{name}.{form}")
        for name in kept.names
        for form in ("svg", "png")
    ]
    before = [file.read_bytes() for file in files]
    draw_pictures(workspace, number)
    assert [file.read_bytes() for file in files] == before
    for wrong in ("paths.gif", "../../studio.db", "drawn.json", "crossing.svg"):
        with pytest.raises(NotFoundError, match=f"of evaluation {number}"):
            picture_file(workspace, store, number, wrong)


def test_evaluations_that_differ_in_one_option_become_a_curve(
    workspace: Workspace, store: Store
) -> None:
    first = evaluated(workspace, 1.0, "straight")
    draw_pictures(workspace, first)
    other = evaluated(workspace, 1.0, "scripted:careful")
    assert kept_pictures(workspace, store, first).whole, other
    second = evaluated(workspace, 4.0, "straight")
    assert not kept_pictures(workspace, store, first).whole
    for number in (first, second):
        assert "crossing" in draw_pictures(workspace, number)["pictures"]
        assert kept_pictures(workspace, store, number).whole
    curves = [picture_file(workspace, store, one, "crossing.svg") for one in (first, second)]
    assert curves[0].read_bytes() == curves[1].read_bytes()
    assert "Rocks in the way" in curves[0].read_text()


def test_the_ways_of_a_policy_that_was_fitted_anew_are_not_drawn(
    workspace: Workspace, store: Store
) -> None:
    evastudio.record(workspace, "asteroids", "scripted:careful", 0.2, seed=1)
    evastudio.fit(workspace, 1, learner="knn", name="mine", clock=lambda: 0.0)
    number = evaluated(workspace, 1.0, "mine")
    evastudio.fit(workspace, 1, learner="knn", settings={"k": 1}, name="mine", clock=lambda: 0.0)
    assert draw_pictures(workspace, number)["pictures"] == ["outcomes"]
    left_out = kept_pictures(workspace, store, number).left_out
    assert left_out is not None
    assert "mine changed since" in left_out


def test_how_a_search_went_is_drawn(workspace: Workspace) -> None:
    few = Pegasus(optimiser="hill-climbing", scenarios=2, horizon_s=2.0, population=2, rounds=3)
    evastudio.search(workspace, settings=few, name="searched", clock=lambda: 0.0)
    assert "learning" in draw_pictures(workspace, evaluated(workspace, 1.0, "searched"))["pictures"]


def test_a_damaged_list_and_no_evaluation_are_told(workspace: Workspace, store: Store) -> None:
    number = evaluated(workspace, 1.0, "straight")
    draw_pictures(workspace, number)
    (listed,) = Path(workspace.pictures).glob("*/drawn.json")
    listed.write_text("{")
    with pytest.raises(StorageError, match="drawn again"):
        kept_pictures(workspace, store, number)
    with pytest.raises(NotFoundError, match="no evaluation 9"):
        draw_pictures(workspace, 9)
