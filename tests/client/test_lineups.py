"""Lineups by the client."""

from __future__ import annotations

import numpy as np
import pytest

from evastudio.client import Studio as Client
from evastudio.errors import InvalidInputError, NotFoundError


def test_pilots_and_a_take_are_looked_at_side_by_side(far: Client) -> None:
    session = far.sessions.create("asteroids", "Beside a policy")
    making = far.takes.begin(session.id, seed=3, options={"density": 2.0})
    making.act(np.zeros((30, 2)))
    take = making.close()
    lineup = far.lineups.open("asteroids", [take.id, "straight"], options={"density": 2.0})
    assert lineup.columns[0].outcome is None
    assert lineup.columns[1].title == "straight"
    assert lineup.columns[1].happenings[-1].kind == "outcome"
    assert lineup in list(far.lineups)
    assert far.lineups.seek(lineup.id, 1.0).position_s == 1.0
    assert far.lineups.roll(lineup.id, 0.5).speed == 0.5
    camera = lineup.cameras[-1]
    assert far.lineups.look_through(lineup.id, camera).camera == camera
    assert far.lineups.standing(lineup.id).position_s >= 1.0
    far.lineups.close(lineup.id)
    with pytest.raises(NotFoundError):
        far.lineups.get(lineup.id)
    with pytest.raises(InvalidInputError):
        far.lineups.open("asteroids", ["straight"])
