"""Runs made into files: a page that needs nothing else, and a video that a player can open."""

from __future__ import annotations

import io
from dataclasses import replace
from pathlib import Path

import av
import numpy as np
import pytest

from evastudio.errors import ConflictError, InvalidInputError, NotFoundError
from evastudio.live import films
from evastudio.live import footage as footages
from evastudio.live.footage import file_name, footage_of, frames, policy_footage
from evastudio.studio import filming
from evastudio.studio.painter import Painter
from evastudio.workspace import Workspace
from evastudio.world.bodies import Camera


def test_a_video_has_every_frame_in_its_size_and_they_differ(
    workspace: Workspace, tmp_path: Path
) -> None:
    footage = policy_footage(workspace, "crowd-shy", 0, {"length": 5.0}, None)
    told = filming.film(workspace, footage, "mp4", (160, 90), tmp_path / "shy.mp4")
    assert told["film"] == str(tmp_path / "shy.mp4")
    with av.open(io.BytesIO((tmp_path / "shy.mp4").read_bytes())) as container:
        (stream,) = container.streams.video
        assert (stream.width, stream.height, stream.average_rate) == (160, 90, 30)
        shown = [frame.to_ndarray(format="rgb24") for frame in container.decode(stream)]
    assert len(shown) == round(told["seconds"] * 30) + 1
    first, later = shown[0].astype(int), shown[45].astype(int)
    assert np.abs(first - later).mean() > 1.0
    assert first.std() > 20.0


def test_a_page_holds_all_that_it_plays(workspace: Workspace) -> None:
    footage = policy_footage(workspace, "asteroids-careful", 4, {"density": 0.3}, None)
    begun = {name: array[:30] for name, array in footage.moving.items()}
    told = filming.film(workspace, replace(footage, moving=begun))
    (workspace.films / "no-file.html").mkdir()
    (kept,) = films.films(workspace)
    assert kept.name == told["film"] == "asteroids-asteroids-careful-4.html"
    with films.open_film(workspace, kept.name) as file:
        page = file.read().decode()
    assert "__VISER_EMBED_DATA__" in page
    assert "<title>Asteroid field: asteroids-careful, world 4</title>" in page
    films.forget_film(workspace, kept.name)
    with pytest.raises(NotFoundError, match="film"):
        films.open_film(workspace, kept.name)


def test_a_painter_shows_nearer_things_before_farther_ones(workspace: Workspace) -> None:
    footage = policy_footage(workspace, "straight", 4, {"density": 0.3}, None, "asteroids")
    reel = footage.reel(workspace)
    painter = Painter(reel.scene, 160, 90)
    moment, camera = next(frames(reel, None, 30))
    seen = painter.paint(moment, camera).astype(int)
    away = Camera(camera.position, 2 * camera.position - camera.look_at, camera.up)
    behind = painter.paint(moment, away).astype(int)
    middle = np.s_[50:80, 60:100]  # the ship is there, white and in the sun
    assert seen[middle].max() > 200
    assert behind[middle].max() < seen[middle].max()
    with pytest.raises(InvalidInputError, match="camera"):
        painter.paint(moment, Camera(camera.position * np.nan, camera.look_at, camera.up))


def test_what_cannot_be_filmed_is_said(
    workspace: Workspace, monkeypatch: pytest.MonkeyPatch
) -> None:
    footage = policy_footage(workspace, "straight", 4, {"density": 0.1}, "far", "asteroids")
    assert (footage.camera, footage.moments > 100) == ("far", True)
    reel = footage.reel(workspace)
    with pytest.raises(ConflictError, match="Nothing has moved"):
        footage_of(reel, reel.moments()[:1], None, "a", "A")
    with pytest.raises(InvalidInputError, match="no camera"):
        footage_of(reel, reel.moments(), "behind", "a", "A")
    with pytest.raises(InvalidInputError, match="even"):
        filming.film(workspace, footage, "mp4", (161, 90))
    with pytest.raises(InvalidInputError, match="'gif'"):
        filming.film(workspace, footage, "gif")
    monkeypatch.setattr(footages, "MOST_BYTES", len(reel.moments()) * 64 - 1)
    with pytest.raises(InvalidInputError, match="shorter run"):
        footage_of(reel, reel.moments(), None, "a", "A")
    assert file_name("Ärger & Co: 7/..") == "rger-co-7"
