"""Names that lead elsewhere: path traversal in every name that the API takes, in every spelling."""

from __future__ import annotations

import re
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

from evastudio.workspace import shipped
from tests.api.served import raw, status
from tests.motion.walker import bvh, walking

if TYPE_CHECKING:
    from conftest import Studio

API = "/api/v1"
OUT = ("..", "../..", "../../../../../../etc/passwd", "/etc/passwd", "..\\..\\x", "~/x", "", ".")
SPELLINGS = (
    "../../pyproject.toml",
    "..%2f..%2fpyproject.toml",
    "%2e%2e/%2e%2e/pyproject.toml",
    "%2e%2e%2f%2e%2e%2fpyproject.toml",
    "..%5c..%5cpyproject.toml",
    "%252e%252e%252fpyproject.toml",
    "....//....//pyproject.toml",
    "..;/..;/pyproject.toml",
    "%c0%ae%c0%ae%c0%afpyproject.toml",
    "%00",
    "pyproject.toml%00.safetensors",
    "%2fetc%2fpasswd",
    "file:%2f%2f%2fetc%2fpasswd",
    "CON",
    "%ff%fe",
    "%ed%a0%80",
    "a" * 3000,
)
SECRETS = (b"root:x:", b"[build-system]", b"import ", b"SQLite format")
"""What the files hold that these names try to reach."""


def texts(studio: Studio) -> list[tuple[str, str]]:
    """Method and path, from every route that takes a name as text."""
    described = studio.client.get(f"{API}/openapi.json").json()["paths"]
    found = [("GET", "/view/{stage}/"), ("GET", "/web/{file}")]
    for path, methods in described.items():
        for method, operation in methods.items():
            kinds = {
                one["name"]: one["schema"].get("type")
                for one in operation.get("parameters", [])
                if one["in"] == "path"
            }
            if "string" in kinds.values():
                found.append((method.upper(), path))
    return found


def outside(studio: Studio) -> dict[Path, float]:
    """Every file around the workspace and of what is shipped, and when it was changed."""
    folders = [
        studio.workspace.root.parent,
        *(shipped() / room for room in ("policies", "scenes", "web")),
    ]
    inside = {studio.workspace.root / name for name in ("studio.db", "studio.db-wal")}
    return {
        file: file.stat().st_mtime
        for folder in folders
        for file in folder.rglob("*")
        if file.is_file() and file not in inside and not file.name.startswith("studio.db")
    }


def test_attack_path_traversal_in_every_name(studio: Studio) -> None:
    """Sent as it is written: a client would tidy it up first."""
    host = studio.base.removeprefix("http://")
    before = outside(studio)
    routes = texts(studio)
    assert len(routes) >= 15
    for method, path in routes:
        for spelling in SPELLINGS:
            target = re.sub(
                r"{\w+}", spelling.replace("\\", r"\\"), path.replace("{evaluation}", "1")
            )
            answer = raw(
                studio.base,
                f"{method} {target} HTTP/1.1\r\nHost: {host}\r\nConnection: close\r\n"
                f"Authorization: Bearer {studio.token}\r\nContent-Type: application/json\r\n"
                "Content-Length: 2\r\n\r\n{}".encode(),
            )
            assert 400 <= status(answer) < 500, (method, target, answer[:300])
            assert not [secret for secret in SECRETS if secret in answer], (method, target)
    assert outside(studio) == before


@pytest.mark.parametrize("name", OUT)
def test_attack_path_traversal_in_what_is_asked_for(studio: Studio, name: str) -> None:
    """Names within bodies and queries, that files are looked for by."""
    client = studio.client
    before = outside(studio)
    session = client.post(f"{API}/sessions", json={"scene": "asteroids", "name": "Out"}).json()
    answers = [
        client.post(f"{API}/sessions", json={"scene": name, "name": "x"}),
        client.post(f"{API}/stages", json={"scene": name}),
        client.post(f"{API}/worlds", json={"scene": name, "seeds": [1]}),
        client.post(f"{API}/evaluations", json={"scene": "asteroids", "policies": [name]}),
        client.post(f"{API}/evaluations", json={"scene": name, "policies": ["straight"]}),
        client.post(f"{API}/sessions/{session['id']}/fit", json={"name": name}),
        client.post(
            f"{API}/policies/switches",
            json={
                "name": name,
                "entries": [{"policy": "crowd-shy", "when": "after:3s"}, {"policy": "crowd-shy"}],
            },
        ),
        client.put(f"{API}/clips/activities/walk", json={"file": name, "clip": "x"}),
        client.get(f"{API}/pilots", params={"scene": name}),
    ]
    for answer in answers:
        assert 400 <= answer.status_code < 500, (answer.request.url, answer.text[:200])
        assert not [secret for secret in SECRETS if secret in answer.content]
    stage = client.post(f"{API}/stages", json={"scene": "asteroids"}).json()
    for command in ({"name": "play", "policy": name}, {"name": "camera", "camera": name}):
        answer = client.post(f"{API}/stages/{stage['id']}/commands", json=command)
        assert 400 <= answer.status_code < 500
    client.delete(f"{API}/stages/{stage['id']}")
    assert outside(studio) == before


def test_attack_policies_elsewhere_on_the_machine(studio: Studio) -> None:
    """A whole policy file outside of the workspace, named by its path, and by a switch."""
    outside_file = studio.workspace.root.parent / "elsewhere.safetensors"
    outside_file.write_bytes(
        (shipped() / "policies" / "asteroids-careful.safetensors").read_bytes()
    )
    client, path = studio.client, str(outside_file)
    switch = {"name": "leading-out", "entries": [{"policy": path, "when": "after:3s"}]}
    switch["entries"].append({"policy": "straight"})
    stage = client.post(f"{API}/stages", json={"scene": "asteroids"}).json()
    play = {"name": "play", "policy": path}
    worlds = client.post(f"{API}/worlds", json={"scene": "asteroids", "seeds": [1]}).json()
    for answer in (
        client.post(f"{API}/stages/{stage['id']}/commands", json=play),
        client.post(f"{API}/evaluations", json={"scene": "asteroids", "policies": [path]}),
        client.post(f"{API}/worlds/{worlds['id']}/play", json={"pilot": path, "steps": 1}),
        client.get(f"{API}/policies/{path}"),
    ):
        assert answer.status_code == 404, (answer.request.url, answer.text)
    client.delete(f"{API}/stages/{stage['id']}")
    client.delete(f"{API}/worlds/{worlds['id']}")
    made = client.post(f"{API}/switches", json=switch)
    if made.status_code == 202:
        job = made.json()["id"]
        with client.stream("GET", f"{API}/jobs/{job}/events") as events:
            events.read()
        told = client.get(f"{API}/jobs/{job}").json()
        assert told["state"] == "failed"
        assert "There is no policy" in told["error"]
    else:
        assert made.status_code == 404, made.text


def test_attack_uploads_that_would_be_put_elsewhere(studio: Studio) -> None:
    """Good files under names that lead out of their folder are put nowhere."""
    host = studio.base.removeprefix("http://")
    clip = bvh(walking(1.2, 0.2)).encode()
    policy = (shipped() / "policies" / "asteroids-careful.safetensors").read_bytes()
    before = outside(studio)
    for part in ("../", "..%2f", "%2e%2e%2f", "..%5c", "%2fetc%2f", "sub%2f", "-", "%20", "."):
        for target, body in (
            (f"{API}/clips/files/{part}evil.bvh", clip),
            (f"{API}/policies/{part}evil/file", policy),
        ):
            head = (
                f"PUT {target} HTTP/1.1\r\nHost: {host}\r\nConnection: close\r\n"
                f"Authorization: Bearer {studio.token}\r\nContent-Length: {len(body)}\r\n"
                "Content-Type: application/octet-stream\r\n\r\n"
            )
            assert 400 <= status(raw(studio.base, head.encode() + body)) < 500, target
    assert outside(studio) == before


def test_attack_links_in_the_workspace(studio: Studio) -> None:
    """A name that is a link is not followed out of where policies and clips lie, to be written."""
    target = studio.workspace.root.parent / "precious.txt"
    target.write_text("precious")
    studio.workspace.motion.mkdir(exist_ok=True)
    link = studio.workspace.motion / "linked.bvh"
    link.symlink_to(target)
    try:
        answer = studio.client.put(
            f"{API}/clips/files/linked.bvh", content=bvh(walking(1.2, 0.2)).encode()
        )
        assert answer.status_code in {200, 422}
        assert target.read_text() == "precious"
    finally:
        link.unlink()
        target.unlink()
        if not any(studio.workspace.motion.iterdir()):
            studio.workspace.motion.rmdir()
