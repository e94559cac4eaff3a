"""Nobody gets in without the token, from another host name, or from another site."""

from __future__ import annotations

import asyncio
import http.client
from collections.abc import Mapping
from typing import TYPE_CHECKING

import httpx
import pytest
from websockets.asyncio.client import connect
from websockets.exceptions import InvalidStatus

from evastudio.api.access import Door

if TYPE_CHECKING:
    from conftest import Studio

PATHS = [
    ("GET", "/"),
    ("GET", "/web/index.html"),
    ("GET", "/view/abc/"),
    ("GET", "/openapi.json"),
    ("GET", "/api/v1/scenes"),
    ("GET", "/api/v1/sessions"),
    ("POST", "/api/v1/sessions"),
    ("GET", "/api/v1/sessions/1"),
    ("GET", "/api/v1/sessions/1/takes"),
    ("POST", "/api/v1/sessions/1/clean"),
    ("DELETE", "/api/v1/sessions/1/clean"),
    ("POST", "/api/v1/sessions/1/fit"),
    ("POST", "/api/v1/sessions/1/tune"),
    ("POST", "/api/v1/sessions/1/diagnose"),
    ("POST", "/api/v1/takes/1/trash"),
    ("POST", "/api/v1/takes/1/restore"),
    ("GET", "/api/v1/policies"),
    ("POST", "/api/v1/policies/switches"),
    ("GET", "/api/v1/evaluations"),
    ("POST", "/api/v1/evaluations"),
    ("GET", "/api/v1/evaluations/1"),
    ("GET", "/api/v1/clips"),
    ("PUT", "/api/v1/clips/files/abc"),
    ("PUT", "/api/v1/clips/activities/abc"),
    ("DELETE", "/api/v1/clips/activities/abc"),
    ("GET", "/api/v1/jobs"),
    ("DELETE", "/api/v1/jobs/1"),
    ("POST", "/api/v1/stages"),
    ("GET", "/api/v1/stages/abc"),
    ("POST", "/api/v1/stages/abc/commands"),
    ("DELETE", "/api/v1/stages/abc"),
    ("POST", "/api/v1/worlds"),
    ("GET", "/api/v1/worlds"),
    ("GET", "/api/v1/worlds/abc"),
    ("GET", "/api/v1/worlds/abc/state"),
    ("POST", "/api/v1/worlds/abc/reset"),
    ("POST", "/api/v1/worlds/abc/step"),
    ("POST", "/api/v1/worlds/abc/play"),
    ("DELETE", "/api/v1/worlds/abc"),
    ("GET", "/nothing/here"),
]


def bare(studio: Studio, method: str, path: str, headers: Mapping[str, str] = {}) -> httpx.Response:
    """A request without the client's token."""
    return httpx.request(method, studio.base + path, headers=headers, trust_env=False)


def test_every_route_of_the_api_is_among_those_tried(studio: Studio) -> None:
    described = studio.client.get("/openapi.json").json()["paths"]
    tried = {
        (method.lower(), path.replace("abc", "*").replace("/1", "/*")) for method, path in PATHS
    }
    missing = [
        (method, path)
        for path, methods in described.items()
        for method in methods
        if (method, "/".join("*" if "{" in part else part for part in path.split("/"))) not in tried
        and method != "get"
    ]
    assert missing == []


@pytest.mark.parametrize(("method", "path"), PATHS)
def test_without_the_token_every_route_refuses(studio: Studio, method: str, path: str) -> None:
    for headers in ({}, {"Authorization": "Bearer wrong"}, {"Cookie": f"evastudio-{1}=x"}):
        answer = bare(studio, method, path, headers)
        assert answer.status_code == 401
        assert answer.headers["content-type"] == "application/problem+json"
        assert studio.token not in answer.text
    assert bare(studio, method, path + "?token=wrong").status_code == 401


def test_the_printed_address_gives_a_cookie_and_leaves_the_token_out(studio: Studio) -> None:
    answer = httpx.get(studio.url, trust_env=False)
    assert answer.status_code == 200
    assert 'content="0; url=/"' in answer.text
    assert studio.token not in answer.text
    cookie = answer.headers["set-cookie"]
    assert "HttpOnly" in cookie
    assert "SameSite=strict" in cookie
    value = cookie.partition(";")[0]
    page = bare(studio, "GET", "/", {"Cookie": value})
    assert page.status_code == 200
    assert "default-src 'self'" in page.headers["content-security-policy"]
    assert page.headers["x-content-type-options"] == "nosniff"


def test_the_printed_address_leaves_the_token_out_the_second_time_too(studio: Studio) -> None:
    cookie = httpx.get(studio.url, trust_env=False).headers["set-cookie"].partition(";")[0]
    answer = httpx.get(studio.url, headers={"Cookie": cookie}, trust_env=False)
    assert answer.status_code == 200
    assert 'content="0; url=/"' in answer.text


def test_cookies_of_other_servers_on_this_host_do_not_lock_anybody_out(studio: Studio) -> None:
    cookie = httpx.get(studio.url, trust_env=False).headers["set-cookie"].partition(";")[0]
    for other in ('theme={"dark": true}', "user name=x", "a=b=c", '="'):
        for both in (f"{other}; {cookie}", f"{cookie}; {other}"):
            assert bare(studio, "GET", "/", {"Cookie": both}).status_code == 200


def test_half_an_address_is_refused_not_an_error(studio: Studio) -> None:
    token = {"Authorization": f"Bearer {studio.token}"}
    assert bare(studio, "GET", "/", {**token, "Host": "[::1"}).status_code == 421
    assert bare(studio, "GET", "/", {**token, "Origin": "http://[x"}).status_code == 403


def test_a_host_name_is_known_in_any_case() -> None:
    door = Door("MyHost", 8400, "t" * 20)
    assert door.admits_host("myhost:8400")
    assert door.admits_host("MYHOST:8400")
    assert not door.admits_host("other:8400")


def test_the_cookie_alone_changes_nothing_from_another_site(studio: Studio) -> None:
    cookie = httpx.get(studio.url, trust_env=False).headers["set-cookie"].partition(";")[0]
    body = {"scene": "asteroids", "name": "From elsewhere"}
    url = studio.base + "/api/v1/sessions"
    for origin in (None, "null", "https://evil.example", "http://127.0.0.1:1"):
        headers = {"Cookie": cookie, **({"Origin": origin} if origin else {})}
        assert httpx.post(url, json=body, headers=headers, trust_env=False).status_code == 403
    own = {"Cookie": cookie, "Origin": studio.base}
    assert httpx.post(url, json=body, headers=own, trust_env=False).status_code == 201


def test_another_host_name_is_refused(studio: Studio) -> None:
    host, _, port = studio.base.removeprefix("http://").partition(":")
    for name in ("evil.example", f"evil.example:{port}", "127.0.0.1.evil.example", ""):
        connection = http.client.HTTPConnection(host, int(port))
        connection.putrequest("GET", "/api/v1/scenes", skip_host=True)
        connection.putheader("Host", name)
        connection.putheader("Authorization", f"Bearer {studio.token}")
        connection.endheaders()
        assert connection.getresponse().status == 421
        connection.close()


def refused(url: str, headers: Mapping[str, str]) -> int:
    """The status with which a websocket is turned away."""

    async def attempt() -> int:
        try:
            async with connect(url, additional_headers=headers, proxy=None):
                return 101
        except InvalidStatus as error:
            return error.response.status_code

    return asyncio.run(attempt())


def test_websockets_ask_for_the_token_and_their_own_origin(studio: Studio) -> None:
    stage = studio.client.post("/api/v1/stages", json={"scene": "asteroids"}).json()
    cookie = httpx.get(studio.url, trust_env=False).headers["set-cookie"].partition(";")[0]
    for path in (stage["socket"], stage["view"]):
        url = studio.base.replace("http", "ws") + path
        assert refused(url, {}) == 403
        assert refused(url, {"Origin": studio.base}) == 403
        assert refused(url, {"Cookie": cookie}) == 403
        assert refused(url, {"Cookie": cookie, "Origin": "https://evil.example"}) == 403
        assert refused(url, {"Authorization": "Bearer wrong"}) == 403
    url = studio.base.replace("http", "ws") + stage["socket"]
    assert refused(url, {"Cookie": cookie, "Origin": studio.base}) == 101
    assert refused(url, {"Authorization": f"Bearer {studio.token}"}) == 101
