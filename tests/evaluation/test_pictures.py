"""Pictures: the same bytes each time, every pilot named, and a sentence where none can be drawn."""

from __future__ import annotations

import itertools
from pathlib import Path

import pytest
from matplotlib.figure import Figure

from evastudio.errors import ConflictError, NotFoundError
from evastudio.evaluation import pictures
from evastudio.evaluation.evaluate import evaluate
from evastudio.evaluation.pictures import Curve
from evastudio.live.headless import make_scene
from evastudio.live.picturing import flown
from evastudio.live.piloting import load_pilot
from evastudio.workspace import Workspace


def pictured(folder: Path, scene: str, *names: str) -> dict[str, Figure]:
    place = make_scene(Workspace(folder), scene)
    pilots = {name: load_pilot(Workspace(folder), name, place) for name in names}
    found = evaluate(place, pilots, worlds=2, max_steps=2000, measure_time=False)
    return {"outcomes": pictures.success_rates(found), **flown(place, pilots, found)}


def test_an_evaluation_is_drawn_twice_to_the_same_bytes(tmp_path: Path) -> None:
    names = ("straight", "scripted:keys")
    once, again = (pictured(tmp_path, "asteroids", *names) for _ in range(2))
    assert list(once) == ["outcomes", "paths", "actions", "paths-in-space"]
    for name, figure in once.items():
        text = pictures.drawn(figure, "svg")
        assert text == pictures.drawn(again[name], "svg")
        for pilot in names:
            assert pilot in text.decode()
    files = pictures.save_pictures(once, tmp_path / "drawn")
    assert [path.suffix for path in files] == [".svg", ".png"] * 4
    assert files[1].read_bytes() == pictures.drawn(again["outcomes"], "png")


def test_a_scene_on_the_ground_has_no_picture_in_space(tmp_path: Path) -> None:
    assert "paths-in-space" not in pictured(tmp_path, "crowd", "crowd-shy")


def test_curves_name_their_lines_without_laying_one_name_over_another() -> None:
    rates = {
        name: {1.0: (1.0, (0.9, 1.0)), 4.0: (0.99, (0.9, 1.0))} for name in ("one", "two", "three")
    }
    figure = pictures.crossing_curves(rates, "NH")
    (axes,) = figure.axes
    places = sorted(text.xyann[1] for text in axes.texts)
    assert [text.get_text() for text in axes.texts] == ["one", "two", "three"]
    assert min(high - low for low, high in itertools.pairwise(places)) > 3.0
    many = {str(number): Curve((0.0, 1.0), (0.0, float(number))) for number in range(9)}
    lines = pictures.learning_curves(many, "s", "score", "Search").axes[0].get_lines()
    looks = {(line.get_color(), line.get_linestyle()) for line in lines}
    assert len(looks) == 9


def test_an_unknown_form_and_a_missing_library_are_told(monkeypatch: pytest.MonkeyPatch) -> None:
    figure = pictures.learning_curves({"one": Curve((0.0, 1.0), (0.0, 1.0))}, "s", "score", "")
    with pytest.raises(NotFoundError, match="svg or png"):
        pictures.drawn(figure, "gif")
    monkeypatch.setattr(pictures, "find_spec", lambda name: None)
    with pytest.raises(ConflictError, match=r"evastudio\[pictures\]"):
        pictures.ready()
