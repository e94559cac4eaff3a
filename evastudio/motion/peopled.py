"""Scenes that people walk in: a paved square under a sky, and people whose moves are chosen.

How they move is not the scene's, but the workspace's to choose.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from evastudio.motion.figures import Figures, figures
from evastudio.scenery.beacon import beacon_meshes, ring_body
from evastudio.scenery.paving import paving_bodies, paving_meshes
from evastudio.scenery.skyline import skyline_body, skyline_mesh
from evastudio.world.bodies import Body, Camera, Look, Mesh
from evastudio.world.cast import of_lead
from evastudio.world.scene import Scene
from evastudio.world.snapshot import Snapshot
from evastudio.world.spaces import Array

CHASE = (5.8, 3.4)
"""Metres behind the lead, and above the ground, of the camera that follows."""
OVERVIEW = (-9.0, -9.0, 7.0)
"""Metres from the lead to the camera that looks over everybody."""
BEYOND = (2.5, 2.5, 0.0)
"""Metres from the lead to where that camera looks."""
UP = (0.0, 0.0, 1.0)


class Peopled(Scene):
    """A scene that draws `figures`. Whoever makes it may set other ones; drawing alone uses them.

    What a `step` needs of walking it takes from the shipped figures, so that a take replays
    whatever clips a workspace has. Its snapshots hold `position` (worlds, N, 2), `heading`
    (worlds, N) and `lead`.
    """

    look = Look(
        background=(226, 224, 214),
        fog_near=22.0,
        fog_far=120.0,
        sun_direction=(-0.45, -0.6, 0.66),
        sun=2.7,
        sky=1.7,
        sky_color=(196, 212, 255),
        ground_color=(150, 132, 116),
        zenith=(92, 148, 206),
    )
    _figures: Figures | None = None

    @property
    def figures(self) -> Figures:
        """The bodies that people have; as shipped until others are set."""
        return figures() if self._figures is None else self._figures

    @figures.setter
    def figures(self, chosen: Figures) -> None:
        self._figures = chosen

    def meshes(self) -> Mapping[str, Mesh]:
        """Those of people and of the square; a scene adds its own."""
        return {
            **self.figures.meshes(),
            **paving_meshes(),
            **beacon_meshes(),
            "skyline": skyline_mesh(),
        }

    def square(self, lead: Array) -> list[Body]:
        """The square around the lead, at `lead` (2,), and the ring under them."""
        return [*paving_bodies(lead), skyline_body(lead), ring_body(lead)]

    def cameras(self, snapshot: Snapshot) -> Mapping[str, Camera]:
        here = np.array([*of_lead(snapshot, snapshot["position"])[0], 0.0])
        above = Camera(here + OVERVIEW, here + BEYOND, up=np.array(UP))
        return {"chase": self.camera(snapshot), "overview": above}

    def camera(self, snapshot: Snapshot) -> Camera:
        """Behind the lead."""
        here = np.array([*of_lead(snapshot, snapshot["position"])[0], 0.0])
        heading = float(of_lead(snapshot, snapshot["heading"])[0])
        forward = np.array([np.cos(heading), np.sin(heading), 0.0])
        back, above = CHASE
        return Camera(
            position=here - forward * back + (0.0, 0.0, above),
            look_at=here + forward * 1.7 + (0.0, 0.0, 0.9),
            up=np.array(UP),
        )
