"""What a user installs: the wheel and the sdist, each in an empty venv outside the checkout."""

from __future__ import annotations

import subprocess
import sys
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

from evastudio.workspace import Workspace, shipped

if TYPE_CHECKING:
    from conftest import Studio

CHECKOUT = shipped()


@pytest.fixture(scope="module")
def built(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a freshly built wheel and sdist."""
    out = tmp_path_factory.mktemp("dist")
    subprocess.run(
        [sys.executable, "-m", "build", "--outdir", str(out), str(CHECKOUT)],
        check=True,
        capture_output=True,
    )
    return out


def test_the_wheel_carries_scenes_policies_and_page(built: Path) -> None:
    names = zipfile.ZipFile(next(built.glob("*.whl"))).namelist()
    for folder in ("scenes", "policies", "web"):
        expected = {
            f"evastudio/_shipped/{folder}/{path.relative_to(CHECKOUT / folder)}"
            for path in (CHECKOUT / folder).rglob("*")
            if path.is_file() and "__pycache__" not in path.parts
        }
        assert expected
        assert expected <= set(names)


@pytest.mark.parametrize("kind", ["*.whl", "*.tar.gz"])
def test_it_starts_from_an_empty_venv(
    built: Path, tmp_path: Path, kind: str, start_studio: Callable[..., Studio]
) -> None:
    package = next(built.glob(kind))
    subprocess.run([sys.executable, "-m", "venv", str(tmp_path / "venv")], check=True)
    python = tmp_path / "venv" / "bin" / "python"
    subprocess.run([python, "-m", "pip", "install", "-q", str(package)], check=True)
    where = subprocess.run(
        [python, "-c", "import evastudio; print(evastudio.__file__)"],
        check=True,
        capture_output=True,
        text=True,
        cwd=tmp_path,
    ).stdout
    assert str(tmp_path / "venv") in where
    studio = start_studio(Workspace(tmp_path / "work"), str(python))
    assert "EVA Studio" in studio.client.get("/").text
    assert studio.client.get("/web/js/main.js").status_code == 200
    scenes = studio.client.get("/api/v1/scenes").json()["items"]
    assert "asteroids" in [scene["name"] for scene in scenes]
    policies = studio.client.get("/api/v1/policies").json()["items"]
    shipped_names = {path.stem for path in (CHECKOUT / "policies").glob("*.safetensors")}
    assert shipped_names
    assert shipped_names <= {policy["name"] for policy in policies if policy["shipped"]}
    stage = studio.client.post("/api/v1/stages", json={"scene": "asteroids"}).json()
    assert studio.client.get(stage["view"]).status_code == 200
    played = studio.client.post(
        f"/api/v1/stages/{stage['id']}/commands",
        json={"name": "play", "policy": sorted(shipped_names)[0]},
    )
    assert played.json()["phase"] == "playing"
    assert sorted(path.name for path in (tmp_path / "work").iterdir()) == [
        "policies",
        "signed-in.json",
        "studio.db",
        "studio.db-shm",
        "studio.db-wal",
    ]
