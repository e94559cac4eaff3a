"""Nobody gets in without the token, from another host name, or from another site."""

from __future__ import annotations

import http.client
import re
from collections.abc import Mapping
from typing import TYPE_CHECKING

import httpx

from evastudio.api.door import Door
from tests.api.served import knock

if TYPE_CHECKING:
    from conftest import Studio

BESIDE = [
    ("GET", "/"),
    ("GET", "/web/index.html"),
    ("GET", "/view/abc/"),
    ("GET", "/api/v1/openapi.json"),
    ("GET", "/nothing/here"),
]
"""What is reached beside the API."""


def bare(studio: Studio, method: str, path: str, headers: Mapping[str, str] = {}) -> httpx.Response:
    """A request without the client's token."""
    return httpx.request(method, studio.base + path, headers=headers, trust_env=False)


def test_without_the_token_every_route_refuses(studio: Studio) -> None:
    described = studio.client.get("/api/v1/openapi.json").json()["paths"]
    routes = BESIDE + [
        (method.upper(), re.sub(r"{\w+}", "1", path))
        for path, methods in described.items()
        for method in methods
    ]
    assert len(routes) >= 40
    with httpx.Client(base_url=studio.base, trust_env=False) as stranger:
        for method, path in routes:
            for headers in ({}, {"Authorization": "Bearer wrong"}, {"Cookie": "evastudio-1=x"}):
                answer = stranger.request(method, path, headers=headers)
                assert answer.status_code == 401, (method, path)
                assert answer.headers["content-type"] == "application/problem+json"
                assert studio.token not in answer.text
            assert stranger.request(method, path + "?token=wrong").status_code == 401


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
    assert "default-src 'none'" in page.headers["content-security-policy"]
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


def test_behind_a_proxy_the_public_name_and_origin_are_ones_own() -> None:
    door = Door("127.0.0.1", 8400, "https://studio.example")
    assert door.admits_host("studio.example")
    assert not door.admits_host("studio.example:8400")
    assert not door.admits_host("studio.example.evil.example")
    assert door.origin("studio.example") == "https://studio.example"
    assert door.origin("127.0.0.1:8400") == "http://127.0.0.1:8400"
    assert door.cookie("studio.example") == "__Host-evastudio-8400"
    assert door.secure("studio.example")
    assert not door.secure("127.0.0.1:8400")


def test_a_host_name_is_known_in_any_case() -> None:
    door = Door("MyHost", 8400)
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


def test_websockets_ask_for_the_token_and_their_own_origin(studio: Studio) -> None:
    stage = studio.client.post("/api/v1/stages", json={"scene": "asteroids"}).json()
    cookie = httpx.get(studio.url, trust_env=False).headers["set-cookie"].partition(";")[0]
    for path in (stage["socket"], stage["view"]):
        url = studio.base.replace("http", "ws") + path
        assert knock(url, {}) == 403
        assert knock(url, {"Origin": studio.base}) == 403
        assert knock(url, {"Cookie": cookie}) == 403
        assert knock(url, {"Cookie": cookie, "Origin": "https://evil.example"}) == 403
        assert knock(url, {"Authorization": "Bearer wrong"}) == 403
    url = studio.base.replace("http", "ws") + stage["socket"]
    assert knock(url, {"Cookie": cookie, "Origin": studio.base}) == 101
    assert knock(url, {"Authorization": f"Bearer {studio.token}"}) == 101
