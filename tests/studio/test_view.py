"""Views over a real websocket: what browsers get, when, and what cannot hurt them."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable, Sequence

import numpy as np
import pytest
from websockets.asyncio.client import connect
from websockets.exceptions import ConnectionClosed, InvalidStatus

from evastudio.errors import InvalidInputError, NotFoundError
from evastudio.studio.view import View
from evastudio.world.bodies import Body
from evastudio.world.snapshot import Snapshot
from tests.studio.drawn import CORNERS, Slide, at, drained, joined, named, replay, served, window


def run(test: Callable[[View, str], Awaitable[None]], scene: Slide | None = None) -> None:
    """Run `test` with a view and its address."""

    async def inside() -> None:
        view = View(scene or Slide(), asyncio.get_running_loop())
        async with asyncio.timeout(30), served(view) as address:
            await test(view, address)

    asyncio.run(inside())


def test_a_late_joiner_gets_the_scene_as_it_is_now() -> None:
    async def test(view: View, address: str) -> None:
        view.show(at(0.0), fresh=True)
        for x in (1.0, 2.0, 3.0):
            view.show(at(x))
        async with joined(address) as client:
            messages = await replay(client)
            assert view.clients == 1
        posts = named(messages, "BatchedMeshesMessage", "/bodies/posts")
        assert posts["props"]["vertices"]
        named(messages, "BatchedMeshesMessage", "/bodies/sled")
        named(messages, "BatchedGlbMessage", "/bodies/lamp")
        sled = named(messages, "SetPositionMessage", "/bodies/sled")
        assert list(sled["position"]) == [3.0, 0.0, 0.0]
        camera = named(messages, "SetCameraPositionMessage")
        assert list(camera["position"]) == [-5.0, 0.0, 0.0]
        fog = named(messages, "FogMessage")
        assert (fog["near"], fog["far"]) == (5.0, 50.0)

    run(test)


def test_pose_and_camera_of_a_frame_arrive_together() -> None:
    async def test(view: View, address: str) -> None:
        view.show(at(0.0), fresh=True)
        async with joined(address) as client:
            await replay(client)
            for x in np.linspace(0.1, 5.0, 40):
                await asyncio.to_thread(view.show, at(float(x)))
                messages = await window(client)
                sled = named(messages, "SetPositionMessage", "/bodies/sled")
                camera = named(messages, "SetCameraPositionMessage")
                aim = named(messages, "SetCameraLookAtMessage")
                assert sled["position"][0] == pytest.approx(x)
                assert camera["position"][0] == pytest.approx(x - 8.0)
                assert aim["look_at"][0] == pytest.approx(x)
                assert not any("posts" in str(message.get("name")) for message in messages)

    run(test)


def test_a_new_take_moves_what_stands_still() -> None:
    async def test(view: View, address: str) -> None:
        view.show(at(0.0, seed=1), fresh=True)
        async with joined(address) as client:
            await replay(client)
            view.show(at(0.0, seed=2), fresh=True)
            messages = await window(client)
            updates = [m for m in messages if m.get("name") == "/bodies/posts"]
            assert any("batched_positions" in m.get("updates", {}) for m in updates)

    run(test)


def test_a_body_may_change_its_number_and_go() -> None:
    class Herd(Slide):
        count = 5

        def bodies(self, snapshot: Snapshot) -> Sequence[Body]:
            places = np.arange(3.0 * self.count).reshape(-1, 3)
            wxyzs = np.tile((1.0, 0.0, 0.0, 0.0), (self.count, 1))
            return [Body("herd", "lit", places, wxyzs, np.ones(self.count))]

    scene = Herd()

    async def test(view: View, address: str) -> None:
        for scene.count in (5, 1, 0, 3):
            view.show(at(0.0))
        async with joined(address) as client:
            messages = await replay(client)
        named(messages, "BatchedMeshesMessage", "/bodies/herd")

    run(test, scene)


def test_sizes_and_colors_of_instances_are_sent_only_when_they_change() -> None:
    class People(Slide):
        tint = 90

        def bodies(self, snapshot: Snapshot) -> Sequence[Body]:
            places = snapshot["posts"][0] + snapshot["place"][0]
            colors = np.full((5, 3), self.tint, dtype=np.uint8)
            sizes = np.tile([1.0, 2.0, 3.0], (5, 1))
            return [Body("people", "lit", places, np.ones((5, 4)), sizes, colors=colors)]

    scene = People()

    async def test(view: View, address: str) -> None:
        view.show(at(0.0), fresh=True)
        async with joined(address) as client:
            named(await replay(client), "BatchedMeshesMessage", "/bodies/people")
            for tint, sent in ((90, {"positions"}), (30, {"positions", "colors"})):
                scene.tint = tint
                view.show(at(1.0 + tint))
                updates: set[str] = set()
                for message in await window(client):
                    updates |= set(message.get("updates", {}))
                assert updates == {f"batched_{name}" for name in sent}

    run(test, scene)


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
def test_numbers_that_cannot_be_drawn_are_refused_and_nobody_is_lost(value: float) -> None:
    async def test(view: View, address: str) -> None:
        view.show(at(1.0), fresh=True)
        async with joined(address) as client:
            await replay(client)
            with pytest.raises(InvalidInputError, match=r"NaN|finite"):
                view.show(at(value))
            view.show(at(2.0))
            messages = await window(client)
            assert named(messages, "SetPositionMessage", "/bodies/sled")["position"][0] == 2.0
            async with joined(address) as second:
                await replay(second)
                assert view.clients == 2

    run(test)


def test_a_bad_fixed_body_leaves_the_world_before_it_whole() -> None:
    async def test(view: View, address: str) -> None:
        view.show(at(1.0), fresh=True)
        good = at(2.0)
        bad = Snapshot({"posts": good["posts"] * np.nan}, dict(good.moving))
        async with joined(address) as client:
            await replay(client)
            with pytest.raises(InvalidInputError, match="posts"):
                view.show(bad, fresh=True)
            view.show(good)
            messages = await window(client)
            assert named(messages, "SetPositionMessage", "/bodies/sled")["position"][0] == 2.0

    run(test)


def test_a_body_of_the_wrong_shape_or_without_a_mesh_is_named() -> None:
    class Broken(Slide):
        mesh = "lit"

        def bodies(self, snapshot: Snapshot) -> Sequence[Body]:
            return [Body("thing", self.mesh, CORNERS, CORNERS, np.ones(4))]

    async def test(view: View, address: str) -> None:
        with pytest.raises(InvalidInputError, match=r"wxyzs of body 'thing' have shape \(4, 3\)"):
            view.show(at(0.0))

    run(test, Broken())

    class Gaudy(Slide):
        def bodies(self, snapshot: Snapshot) -> Sequence[Body]:
            colors = np.zeros((3, 3), dtype=np.uint8)
            return [Body("thing", "lit", CORNERS, np.ones((4, 4)), np.ones(4), colors=colors)]

    async def gaudy(view: View, address: str) -> None:
        with pytest.raises(InvalidInputError, match=r"colors of body 'thing' are uint8"):
            view.show(at(0.0))

    run(gaudy, Gaudy())

    class Bare(Slide):
        def bodies(self, snapshot: Snapshot) -> Sequence[Body]:
            return [Body("thing", "lost", CORNERS, np.ones((4, 4)), np.ones(4))]

    async def unknown(view: View, address: str) -> None:
        with pytest.raises(NotFoundError, match="lost"):
            view.show(at(0.0))

    run(unknown, Bare())


def test_a_client_of_another_version_is_turned_away() -> None:
    async def test(view: View, address: str) -> None:
        with pytest.raises((InvalidStatus, ConnectionClosed)):
            async with connect(address) as client:
                await client.recv()
        assert view.clients == 0

    run(test)


def test_closing_a_view_ends_its_connections() -> None:
    async def test(view: View, address: str) -> None:
        view.show(at(0.0), fresh=True)
        async with joined(address) as client:
            await replay(client)
            view.close()
            with pytest.raises(ConnectionClosed):
                await drained(client)

    run(test)


def test_a_client_that_sends_rubbish_loses_only_itself(caplog: pytest.LogCaptureFixture) -> None:
    async def test(view: View, address: str) -> None:
        view.show(at(0.0), fresh=True)
        async with joined(address) as good, joined(address) as bad:
            await replay(good)
            await replay(bad)
            await bad.send(b"rubbish")
            with pytest.raises(ConnectionClosed):
                await drained(bad)
            view.show(at(1.0))
            messages = await window(good)
            assert named(messages, "SetPositionMessage", "/bodies/sled")["position"][0] == 1.0

    run(test)
