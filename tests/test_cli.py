"""The command line: the same functions, JSON that scripts rely on, one sentence for mistakes."""

from __future__ import annotations

import json
import socket
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from evastudio.errors import InvalidInputError
from evastudio.server import _listen
from evastudio.workspace import shipped
from tests.motion.walker import bvh, walking


def evastudio(*arguments: str | Path) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-m", "evastudio", *map(str, arguments)],
        capture_output=True,
        text=True,
        check=False,
    )


def as_json(*arguments: str | Path) -> Any:
    done = evastudio(*arguments, "--json")
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


def test_from_recording_to_evaluation(tmp_path: Path) -> None:
    place = ("--workspace", tmp_path)
    made = as_json(
        *("record", "asteroids", "--pilot", "scripted:careful", "--minutes", "0.5"),
        "--seed",
        "3",
        *place,
    )
    assert made["pairs"] == 450
    session = str(made["session"])
    assert [one["id"] for one in as_json("sessions", *place)] == [made["session"]]
    assert as_json("clean", session, *place)["pairs"] == 450
    out = tmp_path / "policy.safetensors"
    fitted = as_json(
        *("fit", session, "--learner", "knn", "--perception", "canonical"), "--out", out, *place
    )
    assert fitted["file"] == str(out)
    result = as_json(
        *("evaluate", out, "scripted:keys", "--worlds", "3", "--seed", "5", "--density", "1"),
        *place,
    )
    assert result["scene"]["options"]["density"] == 1.0
    figures = result["policies"][str(out)]
    assert 0.0 <= figures["interval"][0] <= figures["success_rate"] <= figures["interval"][1] <= 1.0
    plain = evastudio("sessions", *place)
    assert "scripted:careful" in plain.stdout


def test_a_workspace_is_backed_up_and_restored_elsewhere(tmp_path: Path) -> None:
    here, there = tmp_path / "here", tmp_path / "there"
    as_json("record", "asteroids", "--minutes", "0.1", "--session", "Kept", "-w", here)
    made = as_json("backup", tmp_path / "kept.zip", "-w", here)
    assert (made["sessions"], made["pairs"]) == (1, 90)
    assert as_json("restore", tmp_path / "kept.zip", "-w", there) == made
    assert [one["name"] for one in as_json("sessions", "-w", there)] == ["Kept"]
    refused(evastudio("backup", tmp_path / "kept.zip", "-w", here), "there already")


def test_what_a_policy_does_is_made_into_a_page(tmp_path: Path) -> None:
    place, out = ("--workspace", tmp_path), tmp_path / "shy.html"
    told = as_json("film", out, "--policy", "crowd-shy", "--option", "length=5", *place)
    assert (told["film"], told["bytes"]) == (str(out), out.stat().st_size)
    refused(evastudio("film", out, *place), "--take or --policy")
    assert as_json("studies", *place) == []


def test_clips_are_listed_and_chosen(tmp_path: Path) -> None:
    place = ("--workspace", tmp_path)
    (tmp_path / "motion").mkdir()
    (tmp_path / "motion" / "stroll.bvh").write_text(bvh(walking(0.8)))
    (tmp_path / "motion" / "broken.bvh").write_text("HIERARCHY")
    shown = evastudio("clips", "walk", "stroll.bvh", *place).stdout
    assert "no BVH file" in shown
    told = as_json("clips", *place)
    assert {one["name"]: one["clip"] for one in told["activities"]}["walk"] == "stroll"
    told = as_json("clips", "walk", "--shipped", *place)
    assert all(one["file"] is None for one in told["activities"])
    assert evastudio("clips", "walk", *place).returncode == 2


def test_scenes_and_check(tmp_path: Path) -> None:
    assert "asteroids" in [scene["name"] for scene in as_json("scenes", "--workspace", tmp_path)]
    file = shipped() / "scenes" / "asteroids.py"
    assert all(found["ok"] for found in as_json("check", file))
    (tmp_path / "scenes").mkdir()
    broken = tmp_path / "scenes" / "broken.py"
    broken.write_text(file.read_text().replace("turn=heading - before", "turn=heading * np.inf"))
    assert evastudio("check", "broken.py", "--workspace", tmp_path).returncode == 1


def refused(done: subprocess.CompletedProcess[str], says: str) -> None:
    assert done.returncode == 2
    assert says in done.stderr
    assert "Traceback" not in done.stderr
    assert done.stderr.startswith("evastudio: ")
    assert len(done.stderr.strip().splitlines()) == 1


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (("record", "asteroid"), "Did you mean 'asteroids'"),
        (("record", "asteroids", "--density", "-3"), "must be a number from"),
        (("record", "asteroids", "--option", "half_width"), "name=value"),
        (("fit", "12"), "no session '12'"),
        (("fit", "12", "--out", "policy.pkl"), "ends in .safetensors"),
        (("clean", "12", "--threshold", "some"), "must be a number"),
        (("evaluate", "ghost"), "no policy 'ghost'"),
        (("check", "nowhere.py"), "no scene file"),
        (("studio", "--port", "99999"), "from 0 to 65535"),
        (("studio", "--token", "short"), "at least 16"),
        (("studio", "--host", "a..b", "--no-browser"), "cannot listen at a..b"),
        (("record", "asteroids", "--option", "self=1"), "no option 'self' of scene 'asteroids'"),
        (("fit", str(10**20)), "no session '1000"),
        (("sessions", "--store", "nonsense"), "session store"),
        (("evaluate", "crowd-shy", "--scene", "asteroids"), "made for scene 'crowd'"),
        (("evaluate", "straight", "--cluster", "here"), "No Dask scheduler answers at 'here'"),
        (("restore", "nowhere.zip"), "no file"),
    ],
)
def test_a_mistake_is_one_sentence_and_exit_code_2(
    tmp_path: Path, arguments: tuple[str, ...], says: str
) -> None:
    refused(evastudio(*arguments, "--workspace", tmp_path), says)


def test_a_damaged_policy_and_a_foreign_database_are_refused(tmp_path: Path) -> None:
    bad = tmp_path / "bad.safetensors"
    bad.write_bytes(b"\x00\x01 this is no policy")
    refused(evastudio("evaluate", bad, "--workspace", tmp_path), "bad.safetensors")
    (tmp_path / "studio.db").write_text("this is no database, but it is long enough to look at")
    refused(evastudio("sessions", "--workspace", tmp_path), "cannot be opened")
    assert (tmp_path / "studio.db").read_text().startswith("this is no database")


def test_a_port_in_use_is_refused(tmp_path: Path) -> None:
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = str(taken.getsockname()[1])
        done = evastudio("studio", "--port", port, "--no-browser", "--workspace", tmp_path)
    refused(done, f"cannot listen at 127.0.0.1 port {port}")


def test_a_port_belongs_to_one_studio_before_it_serves() -> None:
    with _listen("127.0.0.1", 0) as first, pytest.raises(InvalidInputError, match="listen"):
        _listen("127.0.0.1", first.getsockname()[1])


def test_a_name_with_brackets_is_shown_as_it_is(tmp_path: Path) -> None:
    name = "[/x] [red]"
    made = ("record", "asteroids", "--minutes", "0.05", "--session", name)
    as_json(*made, "--workspace", tmp_path)
    shown = evastudio("sessions", "--workspace", tmp_path)
    assert shown.returncode == 0
    assert name in shown.stdout


def test_an_unknown_command_shows_the_usage() -> None:
    done = evastudio("bogus")
    assert done.returncode == 2
    assert "No such command 'bogus'" in done.stderr
