"""From where a stage is seen: which of the scene's cameras, and what is pointed at through it."""

from __future__ import annotations

from evastudio.errors import not_found
from evastudio.live.aim import ground_at
from evastudio.world.bodies import Camera
from evastudio.world.scene import Scene
from evastudio.world.snapshot import Snapshot

Pointer = tuple[float, float, float]
"""Across and up in the view, each from -1 to 1, and the view's width over its height."""
MIDDLE: Pointer = (0.0, 0.0, 1.0)


class Sight:
    """One of a scene's cameras, chosen by name, and the picture last drawn through it."""

    def __init__(self) -> None:
        self._chosen: str | None = None
        self._drawn: Camera | None = None
        self._names: tuple[str, ...] = ()

    def names(self, scene: Scene, snapshot: Snapshot) -> tuple[str, ...]:
        """Of the scene's cameras, which stay the same while a world lasts."""
        if not self._names:
            self._names = tuple(scene.cameras(snapshot))
        return self._names

    def name(self, scene: Scene, snapshot: Snapshot) -> str:
        """Of the camera in use: the one chosen, or the scene's first where it has none such."""
        known = self.names(scene, snapshot)
        return self._chosen if self._chosen in known else known[0]

    def choose(self, name: str | None, scene: Scene, snapshot: Snapshot) -> None:
        """Use that camera from now on, or the one after the present one. Raises NotFoundError."""
        known = self.names(scene, snapshot)
        if name is None:
            present = known.index(self.name(scene, snapshot))
            name = known[(present + 1) % len(known)]
        if name not in known:
            raise not_found("camera", name, known, f"of scene {scene.name!r}")
        self._chosen = name

    def draw(self, scene: Scene, snapshot: Snapshot) -> Camera:
        """The camera to draw `snapshot` through."""
        self._drawn = scene.cameras(snapshot)[self.name(scene, snapshot)]
        return self._drawn

    def forget(self) -> None:
        """What was drawn belongs to a world that is no more."""
        self._drawn, self._names = None, ()

    def pointed_at(
        self, pointer: Pointer | None, scene: Scene, snapshot: Snapshot
    ) -> tuple[float, float]:
        """The place on the ground at `pointer`, in the picture last drawn or one of `snapshot`.

        In the middle of the view where it is None. Raises InvalidInputError where there is no
        ground.
        """
        camera = self._drawn or scene.cameras(snapshot)[self.name(scene, snapshot)]
        return ground_at(camera, *(pointer or MIDDLE))
