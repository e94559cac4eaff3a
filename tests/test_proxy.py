"""The studio behind a real nginx with TLS, configured as docs/proxy.md says."""

from __future__ import annotations

import asyncio
import json
import os
import re
import shutil
import socket
import ssl
import subprocess
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import httpx
import pytest
import trustme
from websockets.asyncio.client import ClientConnection, connect
from websockets.exceptions import InvalidStatus

from evastudio.studio.mounted import SUBPROTOCOL
from evastudio.workspace import Workspace
from tests.conftest import launch

if TYPE_CHECKING:
    from conftest import Studio

DOCS = Path(__file__).parent.parent / "docs" / "proxy.md"
NAME = "studio.example"
WAIT_S = 60.0


class Here(httpx.HTTPTransport):
    """Finds every name on this machine."""

    def handle_request(self, request: httpx.Request) -> httpx.Response:
        here = httpx.Request(
            request.method,
            request.url.copy_with(host="127.0.0.1"),
            headers=request.headers,
            stream=request.stream,
            extensions={"sni_hostname": request.url.host, **request.extensions},
        )
        return super().handle_request(here)


@dataclass
class Proxied:
    """A studio and the nginx in front of it."""

    studio: Studio
    port: int
    plain_port: int
    trusted: ssl.SSLContext
    log: Path
    """nginx's."""
    events: Path
    """The studio's own log."""

    @property
    def origin(self) -> str:
        return f"https://{NAME}:{self.port}"

    def client(self, **headers: str) -> httpx.Client:
        """A client that finds the public name at the proxy, and no token."""
        return httpx.Client(
            base_url=self.origin,
            headers=headers,
            transport=Here(verify=self.trusted),
            timeout=WAIT_S,
        )

    def author(self) -> httpx.Client:
        return self.client(Authorization=f"Bearer {self.studio.token}")

    def socket(self, path: str, **options: Any) -> connect:
        headers = {"Authorization": f"Bearer {self.studio.token}", **options.pop("headers", {})}
        return connect(
            f"wss://{NAME}:{self.port}{path}",
            host="127.0.0.1",
            port=self.port,
            ssl=self.trusted,
            additional_headers=headers,
            proxy=None,
            max_size=None,
            **options,
        )


def ports(count: int) -> list[int]:
    """That many free ones."""
    sockets = [socket.create_server(("127.0.0.1", 0)) for _ in range(count)]
    found = [one.getsockname()[1] for one in sockets]
    for one in sockets:
        one.close()
    return found


@pytest.fixture(scope="module")
def proxied(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Proxied]:
    folder = tmp_path_factory.mktemp("nginx")
    inner, outer, plain = ports(3)
    authority = trustme.CA()
    certificate = authority.issue_cert(NAME)
    certificate.private_key_and_cert_chain_pem.write_to_path(folder / "fullchain.pem")
    certificate.private_key_pem.write_to_path(folder / "privkey.pem")
    trusted = ssl.create_default_context()
    authority.configure_trust(trusted)

    found = re.search(r"```nginx\n(.*?)```", DOCS.read_text(encoding="utf-8"), re.DOTALL)
    assert found is not None
    text = found[1]
    for told, here in {
        "127.0.0.1:8400": f"127.0.0.1:{inner}",
        "listen 443": f"listen 127.0.0.1:{outer}",
        "listen 80": f"listen 127.0.0.1:{plain}",
        f"/etc/ssl/{NAME}/": f"{folder}/",
        "/var/log/nginx/": f"{folder}/",
        f"https://{NAME}$": f"https://{NAME}:{outer}$",
    }.items():
        assert told in text, told
        text = text.replace(told, here)
    (folder / "evastudio.conf").write_text(text)
    places = "".join(
        f"{kind}_temp_path {folder / kind};"
        for kind in ("client_body", "proxy", "fastcgi", "uwsgi", "scgi")
    )
    user = "user root root;" if os.geteuid() == 0 else ""
    (folder / "nginx.conf").write_text(
        f"{user} pid {folder}/pid; error_log {folder}/errors; worker_processes 1; events {{}}\n"
        f"http {{ {places} include {folder}/evastudio.conf; }}"
    )
    nginx = shutil.which("nginx", path=f"{os.environ['PATH']}:/usr/sbin")
    assert nginx is not None, "nginx is needed: make nginx"
    command = [nginx, "-c", str(folder / "nginx.conf"), "-p", str(folder), "-e", str(folder / "e")]
    public = f"https://{NAME}:{outer}"
    logging = ("--log-format", "json", "--log-level", "info")
    behind = ("--port", str(inner), "--public-url", public, "--behind-proxy", "127.0.0.1")
    with (folder / "events").open("w") as events:
        studio = launch(Workspace(folder / "work"), arguments=(*behind, *logging), events=events)
    subprocess.run(command, check=True, timeout=WAIT_S)  # it listens once this returns
    yield Proxied(studio, outer, plain, trusted, folder / "evastudio.log", folder / "events")
    subprocess.run([*command, "-s", "quit"], check=True, timeout=WAIT_S)
    assert studio.stop() == 0


def test_the_printed_address_leads_in_by_a_secure_cookie_and_leaves_no_token(
    proxied: Proxied,
) -> None:
    assert proxied.studio.base == proxied.origin
    with proxied.client() as client:
        assert client.get("/").status_code == 401
        welcome = client.get("/", params={"token": proxied.studio.token})
        assert welcome.status_code == 200
        cookie = welcome.headers["set-cookie"]
        assert cookie.startswith("__Host-")
        assert {"Secure", "HttpOnly", "Path=/"} <= set(cookie.split("; "))
        assert "max-age" in welcome.headers["strict-transport-security"]
        page = client.get("/")
        assert page.status_code == 200
        assert "<title>" in page.text
        assert client.get("/web/index.html").status_code == 200
        body = {"scene": "asteroids", "name": "flown"}
        assert client.post("/api/v1/sessions", json=body).status_code == 403
        own = {"Origin": proxied.origin}
        assert client.post("/api/v1/sessions", json=body, headers=own).status_code == 201
        other = {"Origin": "https://evil.example"}
        assert client.post("/api/v1/sessions", json=body, headers=other).status_code == 403
        plain = {"Origin": f"http://{NAME}:{proxied.port}"}
        assert client.post("/api/v1/sessions", json=body, headers=plain).status_code == 403
    for log in (proxied.log, proxied.events):
        assert proxied.studio.token not in log.read_text()


def test_plain_http_is_sent_to_the_secure_address(proxied: Proxied) -> None:
    answer = httpx.get(
        f"http://127.0.0.1:{proxied.plain_port}/compare?left=1",
        headers={"Host": NAME},
        trust_env=False,
    )
    assert answer.status_code == 308
    assert answer.headers["location"] == f"{proxied.origin}/compare?left=1"


def test_other_names_get_nothing(proxied: Proxied) -> None:
    with proxied.author() as client:
        with pytest.raises(httpx.RemoteProtocolError):
            client.get("/", headers={"Host": "evil.example"})
        with pytest.raises(httpx.ConnectError, match="unrecognized name"):
            client.get("/", extensions={"sni_hostname": "evil.example"})


def test_large_bodies_are_judged_by_the_studio(proxied: Proxied) -> None:
    with proxied.author() as client:
        large = client.put(
            "/api/v1/policies/large/file",
            content=b"x" * 30_000_000,
            headers={"Content-Type": "application/octet-stream"},
        )
        too_large = client.post("/api/v1/sessions", json={"name": "x" * 3_000_000})
    assert large.status_code == 422
    assert "policy" in large.json()["detail"]
    assert too_large.status_code == 413
    assert "html" not in too_large.headers["content-type"]  # as nginx's own refusals are


def test_a_stage_is_driven_and_seen_through_the_proxy(proxied: Proxied) -> None:
    with proxied.author() as client:
        stage = client.post("/api/v1/stages", json={"scene": "asteroids", "seed": 1}).json()

    async def drive() -> None:
        async with (
            proxied.socket(stage["socket"]) as driving,
            proxied.socket(stage["view"], subprotocols=[SUBPROTOCOL]) as seeing,
        ):
            await driving.send(json.dumps({"type": "command", "name": "demonstrate"}))
            held = {"type": "keys", "held": ["KeyW"], "time_ms": 0.0, "seq": 7}
            await driving.send(json.dumps(held))
            frames = asyncio.create_task(some(seeing, 30))
            acknowledged, pairs = False, 0
            while pairs < 5 or not acknowledged:
                told = json.loads(await driving.recv())
                acknowledged |= told == {"type": "ack", "seq": 7}
                pairs = told.get("pairs", pairs)
            assert await frames > 1000

    async def some(seeing: ClientConnection, messages: int) -> int:
        return sum([len(await seeing.recv()) for _ in range(messages)])

    asyncio.run(asyncio.wait_for(drive(), WAIT_S))


@pytest.mark.parametrize("origin", ["https://evil.example", f"http://{NAME}", "null"])
def test_websockets_of_other_sites_are_refused(proxied: Proxied, origin: str) -> None:
    async def enter() -> None:
        async with proxied.socket("/api/v1/stages/any/socket", headers={"Origin": origin}):
            pass

    with pytest.raises(InvalidStatus, match="403"):
        asyncio.run(enter())


def test_progress_comes_while_the_work_goes_on(proxied: Proxied) -> None:
    asked = {"scene": "asteroids", "policies": ["straight"], "worlds": 100_000}
    with proxied.author() as client:
        job = client.post("/api/v1/evaluations", json=asked).json()["id"]
        states = []
        with client.stream("GET", f"/api/v1/jobs/{job}/events") as events:
            for line in events.iter_lines():
                if not line.startswith("data:"):
                    continue
                state = json.loads(line.removeprefix("data:"))["state"]
                if state == "running" and "running" not in states:
                    assert client.delete(f"/api/v1/jobs/{job}").status_code == 200
                states.append(state)
    assert "running" in states
    assert states[-1] == "cancelled"


def test_the_log_of_both_tells_the_same_id(proxied: Proxied) -> None:
    with proxied.author() as client:
        number = client.get("/api/v1/scenes").headers["x-request-id"]
    assert re.fullmatch("[0-9a-f]{32}", number)
    with proxied.author() as client:  # nginx writes its line after the answer: by now it has
        client.get("/api/v1/scenes")
    assert number in proxied.log.read_text()
    told = [json.loads(line) for line in proxied.events.read_text().splitlines()]
    (request,) = (event for event in told if event.get("request") == number)
    assert request["route"] == "/api/v1/scenes"
