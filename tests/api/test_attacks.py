"""Attacks on who may come in: each by its name, against a studio that really runs."""

from __future__ import annotations

import http.client
import json
import time
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING

import httpx
import pytest

from evastudio.demonstrations.store import Store
from evastudio.live.tokens import Role, Tokens, cookie_of
from tests.api.served import TOKEN, knock, raw, status, within

if TYPE_CHECKING:
    from conftest import Studio

API = "/api/v1"
EVIL = "https://evil.example"


def cookie_from(studio: Studio, token: str | None = None) -> str:
    """The cookie that a browser gets for a token, as it sends it."""
    answer = httpx.get(f"{studio.base}/?token={token or studio.token}", trust_env=False)
    return str(answer.headers["set-cookie"]).partition(";")[0]


@pytest.fixture(scope="module")
def viewer(studio: Studio) -> str:
    """A viewer's token."""
    with Store(studio.workspace.store_url) as store:
        return Tokens(store).add("Attacker", Role.VIEWER, time.time())


@pytest.fixture(scope="module")
def stage(studio: Studio) -> Iterator[Mapping[str, str]]:
    opened = studio.client.post(f"{API}/stages", json={"scene": "asteroids"}).json()
    yield opened
    studio.client.delete(f"{API}/stages/{opened['id']}")


# -- from another site -------------------------------------------------------------------------


@pytest.mark.parametrize("origin", [EVIL, "null", "http://127.0.0.1:1", "http://localhost", ""])
def test_attack_cross_site_websocket(studio: Studio, stage: Mapping[str, str], origin: str) -> None:
    """A page of another site uses the cookie of a browser that is logged in."""
    for path in (stage["socket"], stage["view"]):
        url = studio.base.replace("http", "ws") + path
        assert knock(url, {"Cookie": cookie_from(studio), "Origin": origin}) == 403


def test_attack_csrf_by_a_form(studio: Studio) -> None:
    """A form of another site posts what browsers may post without asking."""
    cookie = cookie_from(studio)
    before = len(studio.client.get(f"{API}/sessions").json()["items"])
    body = json.dumps({"scene": "asteroids", "name": "By a form"})
    for kind in ("text/plain", "application/x-www-form-urlencoded", "multipart/form-data"):
        for origin in (EVIL, "null"):
            answer = httpx.post(
                studio.base + f"{API}/sessions",
                content=body,
                headers={"Cookie": cookie, "Content-Type": kind, "Origin": origin},
                trust_env=False,
            )
            assert answer.status_code == 403
    own = {"Cookie": cookie, "Content-Type": "text/plain", "Origin": studio.base}
    answer = httpx.post(studio.base + f"{API}/sessions", content=body, headers=own, trust_env=False)
    assert answer.status_code == 415
    assert len(studio.client.get(f"{API}/sessions").json()["items"]) == before


def test_attack_reading_across_origins(studio: Studio) -> None:
    """No answer allows another site to read it, not even where it asks first."""
    for method, headers in (
        ("GET", {"Origin": EVIL, "Cookie": cookie_from(studio)}),
        ("OPTIONS", {"Origin": EVIL, "Access-Control-Request-Method": "POST"}),
        ("OPTIONS", {"Origin": EVIL, "Cookie": cookie_from(studio)}),
    ):
        answer = httpx.request(
            method, studio.base + f"{API}/scenes", headers=headers, trust_env=False
        )
        assert answer.status_code in {401, 403}
        assert not [name for name in answer.headers if name.startswith("access-control")]
        assert answer.headers["cross-origin-resource-policy"] == "same-origin"


def test_attack_dns_rebinding(studio: Studio, stage: Mapping[str, str]) -> None:
    """A name of the attacker's leads here, so that the browser takes both for one site."""
    host, _, port = studio.base.removeprefix("http://").partition(":")
    for name in ("evil.example", f"evil.example:{port}", "127.0.0.1.evil.example", f"{host}@evil"):
        connection = http.client.HTTPConnection(host, int(port))
        connection.putrequest("GET", f"{API}/scenes", skip_host=True)
        for header, value in {
            "Host": name,
            "Origin": f"http://{name}",
            "Cookie": cookie_from(studio),
        }.items():
            connection.putheader(header, value)
        connection.endheaders()
        assert connection.getresponse().status == 421
        connection.close()
        headers = {"Host": name, "Origin": f"http://{name}", "Cookie": cookie_from(studio)}
        request = "".join(f"{header}: {value}\r\n" for header, value in headers.items())
        upgrade = (
            f"GET {stage['socket']} HTTP/1.1\r\n{request}Connection: Upgrade\r\nUpgrade: websocket"
            "\r\nSec-WebSocket-Version: 13\r\nSec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==\r\n\r\n"
        )
        assert status(raw(studio.base, upgrade.encode())) == 403


def test_attack_clickjacking(studio: Studio) -> None:
    """Nobody else may put the page into a frame."""
    for path in ("/", f"{API}/scenes", "/web/index.html"):
        headers = studio.client.get(path).headers
        assert headers["x-frame-options"] == "SAMEORIGIN"
        assert "frame-ancestors 'self'" in headers["content-security-policy"]


# -- without a token, or with somebody else's --------------------------------------------------


def test_attack_missing_token_on_websockets(studio: Studio, stage: Mapping[str, str]) -> None:
    for path in (stage["socket"], stage["view"]):
        url = studio.base.replace("http", "ws") + path
        for headers in ({}, {"Origin": studio.base}, {"Authorization": "Bearer "}):
            assert knock(url, headers) == 403
        assert knock(url + f"?token={studio.token}", {"Origin": studio.base}) == 403


def test_attack_stolen_role(studio: Studio, viewer: str) -> None:
    """A viewer says in every way there is that they are an author."""
    cookie = cookie_from(studio, viewer)
    tries: list[dict[str, str]] = [
        {"Authorization": f"Bearer {viewer}", "X-Role": "author", "Role": "author"},
        {"Authorization": f"Bearer {viewer}", "Cookie": cookie},
        {"Cookie": f"{cookie}; role=author", "Origin": studio.base},
        {"Authorization": f"Bearer {viewer}", "X-HTTP-Method-Override": "GET"},
        {"Authorization": f"Bearer {viewer}", "X-Original-URL": f"{API}/scenes"},
    ]
    for headers in tries:
        answer = httpx.post(
            studio.base + f"{API}/sessions?role=author&_method=GET",
            json={"scene": "asteroids", "name": "Stolen", "role": "author"},
            headers=headers,
            trust_env=False,
        )
        assert answer.status_code == 403


def test_attack_answers_heaped_up(studio: Studio, viewer: str) -> None:
    """What a viewer asks is done, and no answer to it is kept, whatever key it came with."""
    with httpx.Client(
        base_url=studio.base, headers={"Authorization": f"Bearer {viewer}"}, trust_env=False
    ) as client:
        path, key = f"{API}/policies/asteroids-careful/decide", {"Idempotency-Key": "heap"}
        answers = [
            client.post(path, json={"states": [[number] * 6]}, headers=key)
            for number in (0.0, 0.0, 1.0)
        ]
        bad = client.post(path, json={"states": []}, headers={"Idempotency-Key": "a b"})
    assert {answer.status_code for answer in answers} == {200}
    assert (bad.status_code, "Idempotency-Key" in bad.text) == (422, True)
    assert not any("idempotency-replayed" in answer.headers for answer in answers)


def test_attack_a_viewers_path_that_looks_like_an_allowed_one(studio: Studio, viewer: str) -> None:
    """What viewers may do is not reached by another spelling of what they may not."""
    with httpx.Client(
        base_url=studio.base, headers={"Authorization": f"Bearer {viewer}"}, trust_env=False
    ) as client:
        for path in (
            f"{API}/policies/x/../../sessions/decide",
            f"{API}/policies/%2e%2e/decide",
            f"{API}/policies/x%2f..%2fswitches/decide",
            f"{API}//policies/x/decide",
            f"{API}/sessions/1/clean/../../../policies/x/decide",
            f"{API}/sessions/1/clean%2f..%2fdecide",
        ):
            assert client.post(path, json={}).status_code in {403, 404, 405, 415, 422}, path
        assert client.delete(f"{API}/policies/crowd-shy").status_code == 403


def test_attack_a_cookie_is_no_token(studio: Studio) -> None:
    """Who steals the cookie has nothing that programs, or another studio, take for a token."""
    value = cookie_from(studio).partition("=")[2]
    assert value == cookie_of(studio.token)
    assert studio.token not in value
    headers = {"Authorization": f"Bearer {value}"}
    answer = httpx.get(studio.base + f"{API}/scenes", headers=headers, trust_env=False)
    assert answer.status_code == 401
    assert httpx.get(f"{studio.base}/?token={value}", trust_env=False).status_code == 401


def test_attack_a_link_that_logs_in_within_a_frame(studio: Studio) -> None:
    """Another page may not have the token swapped for a cookie behind somebody's back."""
    for wanted in ("iframe", "image", "empty", "script"):
        answer = httpx.get(studio.url, headers={"Sec-Fetch-Dest": wanted}, trust_env=False)
        assert answer.status_code == 403
        assert "set-cookie" not in answer.headers


def test_attack_script_in_the_printed_address(studio: Studio) -> None:
    """What follows the token is led on to as an address of this server, and as nothing else."""
    for more in ('&"><script>alert(1)</script>', "&x=%22%3E%3Cscript%3E", "&next=//evil.example"):
        answer = httpx.get(studio.url + more, trust_env=False)
        assert "<script" not in answer.text
        assert "evil.example" not in answer.text or "url=/?next=%2F%2Fevil" in answer.text
        assert 'content="0; url=/' in answer.text


def test_attack_code_made_from_text(studio: Studio, stage: Mapping[str, str]) -> None:
    """No page loads code from elsewhere, and none but viser's own makes any from text."""
    for path in ("/", "/compare", stage["view"]):
        policy = studio.client.get(path).headers["content-security-policy"]
        assert policy.startswith("default-src 'none'; ")
        assert ("'unsafe-eval'" in policy) is path.startswith("/view/")
        assert "http" not in policy
        assert "*" not in policy
    assert "unsafe" not in studio.client.get("/").headers["content-security-policy"]


def test_attack_a_cookie_on_the_way(tmp_path: Path) -> None:
    """Behind TLS the cookie never travels in the clear, and no neighbour's host can set it."""
    with within(tmp_path / "studio", public_url="https://studio.example") as base:
        public = {"Host": "studio.example"}
        with httpx.Client(base_url=base, trust_env=False) as client:
            answer = client.get(f"/?token={TOKEN}", headers=public)
            cookie = answer.headers["set-cookie"]
            assert cookie.startswith("__Host-evastudio-")
            for part in ("Secure", "HttpOnly", "SameSite=strict", "Path=/"):
                assert part in cookie
            assert "Domain" not in cookie
            shown = {**public, "Cookie": cookie.partition(";")[0]}
            body = {"scene": "asteroids", "name": "By proxy"}
            for origin, code in (
                ("https://studio.example", 201),
                ("http://studio.example", 403),
                ("https://studio.example:8443", 403),
                ("https://evil.studio.example", 403),
            ):
                answer = client.post(
                    f"{API}/sessions", json=body, headers={**shown, "Origin": origin}
                )
                assert answer.status_code == code, origin
            local = client.get(f"/?token={TOKEN}").headers["set-cookie"]
            assert "Secure" not in local
