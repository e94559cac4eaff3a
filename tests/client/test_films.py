"""Films by the client."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from evastudio.client import Studio as Client
from evastudio.errors import ConflictError, InvalidInputError, NotFoundError
from tests.conftest import Studio


def test_a_take_is_made_into_a_film_and_fetched(far: Client, tmp_path: Path) -> None:
    session = far.sessions.create("asteroids", "To be filmed")
    making = far.takes.begin(session.id, seed=1)
    with pytest.raises(ConflictError, match="Nothing was recorded"):
        far.films.of_take(making.id)
    making.act(np.zeros((5, 2)))
    done = far.jobs.wait(far.films.of_take(making.close().id, camera="far"))
    assert done.result is not None
    name = done.result["film"]
    (film,) = (one for one in far.films if one.name == name)
    path = far.films.download(name, tmp_path)
    assert (path.name, path.stat().st_size) == (name, film.bytes)
    far.films.delete(name)
    with pytest.raises(NotFoundError, match="film"):
        far.films.download(name, tmp_path)
    with pytest.raises(InvalidInputError):
        far.films.of_take(making.id, "mp4", size=(161, 90))


def test_a_stage_on_which_nothing_moved_has_no_film(far: Client, studio: Studio) -> None:
    stage = studio.client.post("/api/v1/stages", json={"scene": "asteroids"}).json()["id"]
    with pytest.raises(ConflictError, match="Nothing has moved"):
        far.films.of_stage(stage)
    studio.client.delete(f"/api/v1/stages/{stage}")
