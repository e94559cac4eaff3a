"""A view: the first world of a snapshot, drawn for every browser that looks at it."""

from __future__ import annotations

import asyncio
import threading
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import viser
from starlette.websockets import WebSocket
from viser.infra import StateSerializer

from evastudio.errors import InvalidInputError, not_found
from evastudio.studio.air import HORIZON_MOVES, backdrop, horizon, set_air
from evastudio.studio.lines import drawn
from evastudio.studio.mounted import Point, mounted_viser
from evastudio.studio.node import Node, checked
from evastudio.studio.scheme import Scheme, seen_in
from evastudio.studio.turns import Turns
from evastudio.world.bodies import Camera, Line
from evastudio.world.scene import Scene
from evastudio.world.snapshot import Snapshot

OnTurn = Callable[[Camera, Camera], None]
"""Called on the event loop with the camera that a person turned, and what they made of it."""


class View:
    """What browsers see of one stage.

    `show` may be called from any thread. A browser that joins late gets the present frame.
    """

    def __init__(
        self,
        scene: Scene,
        loop: asyncio.AbstractEventLoop,
        scheme: Scheme | None = None,
        on_turn: OnTurn | None = None,
    ) -> None:
        """A view of worlds of `scene`, served on `loop`, for pages in that scheme."""
        self.scene = scene
        """What is shown; it may be replaced by the same scene with other options."""
        self._meshes = scene.meshes()
        self._server = mounted_viser(loop, scene.title)
        self._server.gui.configure_theme(
            dark_mode=scheme is not Scheme.LIGHT,
            show_logo=False,
            show_share_button=False,
            control_width="small",
        )
        self._nodes: dict[str, Node] = {}
        self._lines: dict[str, tuple[Line, Any]] = {}
        self._camera: tuple[Point, Point, Point] | None = None
        self._horizon = -1.0
        self._drawing = threading.Lock()
        self._look = seen_in(scene.look, scheme)
        set_air(self._server, self._look)
        self._turns = Turns()
        if on_turn is not None:
            self._listen(on_turn)

    def _listen(self, on_turn: OnTurn) -> None:
        """Tell `on_turn` whenever a person turns the camera."""

        async def moved(camera: viser.CameraHandle) -> None:
            told = Camera(camera.position, camera.look_at, camera.up_direction)
            turned = self._turns.by_hand(camera.client.client_id, told)
            if turned is not None:
                self._camera = checked_camera(told)
                on_turn(turned, told)

        @self._server.on_client_connect
        async def _(client: viser.ClientHandle) -> None:
            client.camera.on_update(moved)
            await moved(client.camera)

        @self._server.on_client_disconnect
        async def _(client: viser.ClientHandle) -> None:
            self._turns.left(client.client_id)

    @property
    def clients(self) -> int:
        """Number of browsers that look at it now."""
        return self._server.clients

    @property
    def cameras(self) -> list[Point]:
        """Where each browser that has told so is looking from."""
        return [
            tuple(float(part) for part in client.camera.position)  # type: ignore[misc]
            for client in self._server.get_clients().values()
            if client.camera.update_timestamp > 0.0
        ]

    def show(
        self,
        snapshot: Snapshot,
        fresh: bool = False,
        camera: Camera | None = None,
        lines: Sequence[Line] = (),
    ) -> None:
        """Draw the first world of `snapshot`; `fresh` where it is not the world shown before.

        `lines` are drawn over it; one that is the same object as before is not sent again. It is
        seen from `camera`, or from the scene's own where none is given.

        Pose and camera of a frame reach each browser together. The camera is left alone while
        the scene keeps it still, so that a person can look around in a world at rest. Raises
        InvalidInputError, and draws nothing, where the scene gives numbers that cannot be drawn.
        """
        bodies = self.scene.bodies(snapshot)
        seen_from = checked_camera(camera or self.scene.camera(snapshot))
        with self._drawing:
            new = [
                body for body in bodies if fresh or not body.fixed or body.name not in self._nodes
            ]
            arrays = [checked(body) for body in new]
            for body in new:
                if body.mesh not in self._meshes:
                    raise not_found(
                        "mesh", body.mesh, self._meshes, f"of scene {self.scene.name!r}"
                    )
            with self._server.atomic():
                for body, placed in zip(new, arrays, strict=True):
                    if body.name not in self._nodes:
                        mesh = self._meshes[body.mesh]
                        self._nodes[body.name] = Node(self._server, body.name, mesh)
                    self._nodes[body.name].draw(placed)
                self._draw_lines(lines)
                for name in self._nodes.keys() - {body.name for body in bodies}:
                    self._nodes.pop(name).remove()
                if fresh or seen_from != self._camera:
                    self._turns.sent(Camera(*map(np.array, seen_from)))
                    self._server.set_camera(*seen_from)
                    self._camera = seen_from
                    self._set_sky(horizon(*seen_from[:2]))
            self._server.flush()

    def _draw_lines(self, lines: Sequence[Line]) -> None:
        for name in self._lines.keys() - {line.name for line in lines}:
            self._lines.pop(name)[1].remove()
        for line in lines:
            known = self._lines.get(line.name)
            if known is None or known[0] is not line:
                if known is not None:
                    known[1].remove()
                self._lines[line.name] = (line, drawn(self._server, line))

    def _set_sky(self, at: float) -> None:
        """Let the sky end at that horizon, where there is a sky and it has moved visibly."""
        if self._look.zenith is not None and abs(at - self._horizon) > HORIZON_MOVES:
            self._horizon = at
            self._server.scene.set_background_image(backdrop(self._look, at), format="png")

    def recording(self) -> StateSerializer:
        """What is shown from now on, as viser's own client can play it again."""
        return self._server.get_scene_serializer()

    async def handle(self, websocket: WebSocket, heard: bool = True) -> None:
        """Serve one browser's websocket until it leaves; look at what it sends where `heard`."""
        await self._server.handle(websocket, heard)

    def close(self) -> None:
        """End every connection."""
        self._server.close()


def checked_camera(camera: Camera) -> tuple[Point, Point, Point]:
    """Position, point looked at and up of `camera`, all finite."""
    points: list[Point] = []
    for name in ("position", "look_at", "up"):
        array = np.asarray(getattr(camera, name), dtype=np.float64)
        if array.shape != (3,) or not np.isfinite(array).all():
            raise InvalidInputError(
                f"The camera's {name} is {array.tolist()}; it must be three finite numbers."
            )
        x, y, z = array.tolist()
        points.append((x, y, z))
    return points[0], points[1], points[2]
