"""Authors and viewers: named tokens, what each may do, and what a revoked one still can."""

from __future__ import annotations

import asyncio
import json
import re
import time
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import httpx
import pytest
from fastapi import FastAPI
from fastapi.routing import iter_route_contexts
from starlette.routing import WebSocketRoute
from websockets.asyncio.client import connect
from websockets.exceptions import ConnectionClosed, InvalidStatus

from evastudio.api.rights import SOCKET, VIEWERS_MAY, may
from evastudio.demonstrations.store import Store
from evastudio.errors import ConflictError, InvalidInputError, NotFoundError
from evastudio.live.tokens import Role, Tokens, cookie_of, digest
from evastudio.server import create_app
from evastudio.settings import Settings
from evastudio.workspace import Workspace
from tests.studio.drawn import drained

if TYPE_CHECKING:
    from conftest import Studio

API = "/api/v1"


def let_in(studio: Studio, name: str, role: Role) -> str:
    """A new token of the store that `studio` uses, made by another program."""
    with Store(studio.workspace.store_url) as store:
        return Tokens(store).add(name, role, time.time())


def client_of(studio: Studio, token: str) -> httpx.Client:
    return httpx.Client(
        base_url=studio.base, headers={"Authorization": f"Bearer {token}"}, trust_env=False
    )


@pytest.fixture(scope="module")
def viewer(studio: Studio) -> Iterator[httpx.Client]:
    with client_of(studio, let_in(studio, "Vera", Role.VIEWER)) as client:
        yield client


@pytest.fixture(scope="module")
def app(tmp_path_factory: pytest.TempPathFactory) -> FastAPI:
    return create_app(Settings(Workspace(tmp_path_factory.mktemp("app")), port=8400), 8400)


def sockets(app: FastAPI) -> list[str]:
    """Paths of all websockets."""
    return [
        found.path
        for found in iter_route_contexts(app.routes)
        if isinstance(found.original_route, WebSocketRoute) and found.path is not None
    ]


def concrete(path: str) -> str:
    """A path with its names filled in."""
    return re.sub(r"{\w+(:\w+)?}", "1", path)


# -- tokens ------------------------------------------------------------------------------------


def test_a_token_is_kept_as_a_digest_only(store: Store) -> None:
    secret = Tokens(store).add("Ada", Role.AUTHOR, 1.0)
    assert len(secret) >= 43
    with store.engine.connect() as connection:
        (row,) = connection.exec_driver_sql("SELECT * FROM tokens")
    assert secret not in str(row)
    assert cookie_of(secret) not in str(row)
    assert row.digest == digest(secret)


def test_a_token_and_its_cookie_are_not_each_other(store: Store) -> None:
    tokens = Tokens(store)
    secret = tokens.add("Ada", Role.VIEWER, 1.0)
    found = tokens.holder(secret)
    assert found is not None
    assert (found.name, found.role) == ("Ada", Role.VIEWER)
    assert tokens.holder(cookie_of(secret), cookie=True) == found
    assert tokens.holder(cookie_of(secret)) is None
    assert tokens.holder(secret, cookie=True) is None


def test_a_name_has_one_token_until_that_is_revoked(store: Store) -> None:
    tokens = Tokens(store)
    first = tokens.add("Ada", Role.AUTHOR, 1.0)
    with pytest.raises(ConflictError, match="has a token already"):
        tokens.add("Ada", Role.VIEWER, 2.0)
    tokens.revoke("Ada", 3.0)
    assert tokens.holder(first) is None
    assert tokens.good() == set()
    second = tokens.add("Ada", Role.VIEWER, 4.0)
    assert tokens.holder(second) is not None
    assert [(one.role, one.revoked_at) for one in tokens.all()] == [
        ("author", 3.0),
        ("viewer", None),
    ]
    with pytest.raises(NotFoundError, match="evastudio tokens"):
        tokens.revoke("Bob", 5.0)


@pytest.mark.parametrize("name", ["", "  ", "a\nb", "x" * 81, "\x1b[31m"])
def test_a_name_that_cannot_be_shown_is_refused(store: Store, name: str) -> None:
    with pytest.raises(InvalidInputError, match="letters that can be"):
        Tokens(store).add(name, Role.VIEWER, 1.0)


# -- what a viewer may do ----------------------------------------------------------------------


def test_one_is_told_who_one_is(studio: Studio, viewer: httpx.Client) -> None:
    assert viewer.get(f"{API}/me").json() == {"name": "Vera", "role": "viewer"}
    assert studio.client.get(f"{API}/me").json()["role"] == "author"


def test_a_viewer_reads(viewer: httpx.Client) -> None:
    for path in ("/", "/api/v1/openapi.json", f"{API}/scenes", f"{API}/policies", f"{API}/stages"):
        assert viewer.get(path).status_code == 200


def test_no_route_lets_a_viewer_change_anything(studio: Studio, viewer: httpx.Client) -> None:
    described = studio.client.get("/api/v1/openapi.json").json()["paths"]
    tried = 0
    for path, methods in described.items():
        for method in {"post", "put", "patch", "delete"} & set(methods):
            if (method.upper(), path) in VIEWERS_MAY:
                continue
            answer = viewer.request(method, concrete(path), json={})
            assert answer.status_code == 403, (method, path)
            assert answer.headers["content-type"] == "application/problem+json"
            assert "viewer" in answer.json()["detail"]
            tried += 1
    assert tried >= 15
    for method in ("POST", "PUT", "PATCH", "DELETE", "TRACE", "PROPFIND"):
        assert viewer.request(method, "/nothing/here").status_code == 403


def test_no_websocket_lets_a_viewer_in_unless_it_is_listed(app: FastAPI) -> None:
    paths = sockets(app)
    assert len(paths) >= 3
    for path in paths:
        listed = (SOCKET, path) in VIEWERS_MAY
        assert may(Role.VIEWER, SOCKET, concrete(path)) is listed, path
        assert may(Role.AUTHOR, SOCKET, concrete(path))


def test_what_is_listed_for_viewers_exists(app: FastAPI) -> None:
    there = {(SOCKET, path) for path in sockets(app)}
    there |= {
        (method.upper(), path)
        for path, methods in app.openapi()["paths"].items()
        for method in methods
    }
    assert set(VIEWERS_MAY) <= there


def test_a_viewer_watches_a_stage_and_drives_nothing(studio: Studio, viewer: httpx.Client) -> None:
    stage = studio.client.post(f"{API}/stages", json={"scene": "asteroids", "seed": 1}).json()
    assert stage in viewer.get(f"{API}/stages").json()["items"]

    async def watch() -> None:
        url = studio.base.replace("http", "ws") + stage["socket"]
        headers = {"Authorization": viewer.headers["Authorization"]}
        async with asyncio.timeout(30), connect(url, additional_headers=headers, proxy=None) as one:
            for message in (
                {"type": "command", "name": "demonstrate"},
                {"type": "keys", "held": ["KeyA"], "time_ms": 0.0, "seq": 1},
                {"type": "keys", "held": [], "pushed": {"theta": 1.0}, "time_ms": 0.0, "seq": 2},
                {"type": "command", "name": "series", "wanted": 3, "automatic": True},
                {"type": "command", "name": "play", "policy": "straight"},
            ):
                await one.send(json.dumps(message))
                told: dict[str, Any] = {"type": "status"}
                while told["type"] == "status":
                    told = json.loads(await one.recv())
                assert told["type"] == "notice"
                assert "viewer" in told["text"]

    asyncio.run(watch())
    assert studio.client.get(f"{API}/stages/{stage['id']}").json()["phase"] == "ready"
    studio.client.delete(f"{API}/stages/{stage['id']}")


# -- what a revoked token can ------------------------------------------------------------------


def test_a_revoked_token_is_refused_at_once_and_its_sockets_are_cut(studio: Studio) -> None:
    token = let_in(studio, "Rita", Role.AUTHOR)
    cookie = httpx.get(f"{studio.base}/?token={token}", trust_env=False).headers["set-cookie"]
    headers = {"Cookie": cookie.partition(";")[0], "Origin": studio.base}
    with client_of(studio, token) as client:
        stage = client.post(f"{API}/stages", json={"scene": "asteroids"}).json()

        async def be_cut() -> None:
            bases = [studio.base.replace("http", "ws") + stage[part] for part in ("socket", "view")]
            async with (
                asyncio.timeout(30),
                connect(bases[0], additional_headers=headers, proxy=None) as drive,
                connect(
                    bases[1],
                    additional_headers=headers,
                    proxy=None,
                    subprotocols=["viser-v1.1.1"],  # type: ignore[list-item]
                ) as view,
            ):
                with Store(studio.workspace.store_url) as store:
                    Tokens(store).revoke("Rita", time.time())
                for socket in (drive, view):
                    with pytest.raises(ConnectionClosed) as closed:
                        await drained(socket)
                    assert closed.value.rcvd is not None
                    assert closed.value.rcvd.code in {4401, 1001}
            with pytest.raises(InvalidStatus):
                async with connect(bases[0], additional_headers=headers, proxy=None):
                    pass

        asyncio.run(be_cut())
        assert client.get(f"{API}/scenes").status_code == 401
    answer = httpx.get(studio.base + f"{API}/scenes", headers=headers, trust_env=False)
    assert answer.status_code == 401
    assert studio.client.delete(f"{API}/stages/{stage['id']}").status_code == 204
