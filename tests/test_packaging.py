"""What a user installs: the wheel and the sdist, each in an empty venv outside the checkout."""

from __future__ import annotations

import json
import subprocess
import sys
import zipfile
from collections.abc import Callable
from dataclasses import dataclass
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


@dataclass(frozen=True)
class Installed:
    """What was built, in a venv of its own that holds nothing else."""

    package: Path
    python: Path

    def run(self, place: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
        """Its Python with these arguments, in the folder `place`, away from the checkout."""
        command = [str(self.python), *arguments]
        return subprocess.run(command, capture_output=True, text=True, cwd=place)


@pytest.fixture(scope="module")
def installed(
    built: Path, tmp_path_factory: pytest.TempPathFactory, request: pytest.FixtureRequest
) -> Installed:
    """The wheel or the sdist, by the pattern of its name."""
    place = tmp_path_factory.mktemp("venv")
    subprocess.run([sys.executable, "-m", "venv", str(place)], check=True)
    made = Installed(next(built.glob(request.param)), place / "bin" / "python")
    subprocess.run([made.python, "-m", "pip", "install", "-q", str(made.package)], check=True)
    return made


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


@pytest.mark.parametrize("installed", ["*.whl", "*.tar.gz"], indirect=True)
def test_it_starts_from_an_empty_venv(
    installed: Installed, tmp_path: Path, start_studio: Callable[..., Studio]
) -> None:
    where = installed.run(tmp_path, "-c", "import evastudio; print(evastudio.__file__)")
    assert str(installed.python.parents[1]) in where.stdout
    studio = start_studio(Workspace(tmp_path / "work"), str(installed.python))
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


@pytest.mark.parametrize("installed", ["*.whl"], indirect=True)
def test_a_video_needs_its_extra_and_nothing_else(installed: Installed, tmp_path: Path) -> None:
    short = ("--policy=straight", "--scene=asteroids", "--density=10", "--width=64", "--height=64")
    film = ("-m", "evastudio", "film", "out.mp4", *short, "--json")
    refused = installed.run(tmp_path, *film)
    assert refused.returncode == 2
    assert "pip install 'evastudio[video]'" in refused.stderr
    extra = f"{installed.package}[video]"
    subprocess.run([installed.python, "-m", "pip", "install", "-q", extra], check=True)
    made = installed.run(tmp_path, *film)
    assert made.returncode == 0, made.stderr
    video = (tmp_path / "out.mp4").read_bytes()
    assert (video[4:8], json.loads(made.stdout)["bytes"]) == (b"ftyp", len(video))
