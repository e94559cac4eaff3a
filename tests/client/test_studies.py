"""Studies by the client."""

from __future__ import annotations

import numpy as np
import pytest

from evastudio.client import Studio as Client
from evastudio.errors import NotFoundError


def test_a_study_is_kept_gone_on_with_and_forgotten(far: Client) -> None:
    session = far.sessions.create("asteroids", "Of somebody else who agreed")

    def fly() -> None:
        making = far.takes.begin(session.id, seed=1)
        making.act(np.zeros((15, 2)))
        making.close()

    fly()
    study = far.studies.keep(session.id, "artist", instructed_s=90.5)
    assert (study.scene, study.instructed_s, study.demonstrated_s) == ("asteroids", 90.5, 1.0)
    fly()
    again = far.studies.replace(study.id, session.id, "artist", preferred="their own")
    assert (again.id, again.demonstrated_s, again.instructed_s) == (study.id, 2.0, None)
    assert again in list(far.studies)
    far.studies.forget(study.id)
    with pytest.raises(NotFoundError):
        far.studies.forget(study.id)
