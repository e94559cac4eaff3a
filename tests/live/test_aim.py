import numpy as np
import pytest

from evastudio.errors import InvalidInputError
from evastudio.live.aim import ground_at
from evastudio.world.bodies import Camera

UP = np.array([0.0, 0.0, 1.0])


def camera(position, look_at):
    return Camera(np.array(position, dtype=float), np.array(look_at, dtype=float), UP)


def test_the_middle_of_the_view_is_where_the_camera_looks() -> None:
    assert ground_at(camera((1, 2, 5), (4, 6, 0)), 0.0, 0.0, 1.6) == pytest.approx((4.0, 6.0))


def test_edges_of_the_view_are_half_its_angle_away() -> None:
    above = Camera(np.array([0.0, 0.0, 10.0]), np.zeros(3), np.array([0.0, 1.0, 0.0]))
    reach = 10.0 * np.tan(np.radians(30.0))
    assert ground_at(above, 0.0, 1.0, 2.0) == pytest.approx((0.0, reach))
    assert ground_at(above, 1.0, 0.0, 2.0) == pytest.approx((2.0 * reach, 0.0))


@pytest.mark.parametrize("up", [0.9, 0.0])
def test_the_sky_is_no_ground(up: float) -> None:
    with pytest.raises(InvalidInputError, match="point lower"):
        ground_at(camera((0, 0, 2), (10, 0, 2)), 0.0, up, 1.0)
