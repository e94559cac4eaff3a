"""The doctor says what is wrong with a workspace, mends what it can, and deletes nothing."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from sqlalchemy import delete, update

from evastudio.demonstrations import schema
from evastudio.demonstrations.recorder import Recorder
from evastudio.demonstrations.store import Store
from evastudio.learning.switch import Entry, Switch, save_switch
from evastudio.live import headless
from evastudio.live.doctor import Finding, examine
from evastudio.workspace import Workspace
from evastudio.world.conditions import parse_condition


@pytest.fixture
def recorded(workspace: Workspace) -> Workspace:
    headless.record(workspace, "asteroids", minutes=0.3, session="Recorded")
    return workspace


@pytest.fixture
def store(recorded: Workspace) -> Iterator[Store]:
    with Store(recorded.store_url) as opened:
        yield opened


def about(findings: list[Finding], word: str) -> Finding:
    (found,) = (one for one in findings if word in one.about or word in one.problem)
    return found


def mended(workspace: Workspace, word: str) -> Finding:
    """What is found of `word`, mended; afterwards nothing is found of it."""
    assert not about(examine(workspace), word).mended
    found = about(examine(workspace, mend=True), word)
    assert found.mended
    assert not [one for one in examine(workspace) if word in one.about or word in one.problem]
    return found


def test_a_healthy_workspace_and_an_empty_one_are_told_nothing_of(
    recorded: Workspace, tmp_path: Path
) -> None:
    assert examine(recorded) == []
    empty = tmp_path / "empty"
    empty.mkdir()
    assert examine(Workspace(empty)) == []
    assert list(empty.iterdir()) == [], "looking makes nothing"
    (missing,) = examine(Workspace(tmp_path / "missing"))
    assert "no such folder" in missing.problem


def test_takes_that_wait_are_saved(recorded: Workspace, store: Store) -> None:
    scene = headless.make_scene(recorded, "asteroids")
    before = store.session("Recorded").pairs
    url = f"sqlite:///file:{recorded.root / 'studio.db'}?mode=ro&uri=true"
    with Store(url) as unwritable:
        recorder = Recorder(unwritable, 1, folders=recorded.unsaved)
        snapshot = scene.worlds([1])
        recorder.begin(scene, snapshot, 1, "test", 0.0)
        for _ in range(9):
            recorder.add(scene.perception().perceive(snapshot).states, np.zeros((1, 2)), snapshot)
        recorder.close(1.0, patience_s=0.0)
    assert "9 pairs of 1 takes wait" in mended(recorded, "wait to be saved").problem
    assert store.session("Recorded").pairs == before + 9


def test_damaged_takes_go_to_the_trash(recorded: Workspace, store: Store) -> None:
    (first,) = store.takes(1)
    chunks = schema.chunks
    with store.engine.begin() as connection:
        connection.execute(update(chunks).values(arrays=b"torn"))
    assert "damaged" in mended(recorded, "cannot be learned from").problem
    assert store.take(first.id).trashed


def test_a_take_with_a_gap_and_one_without_pairs_go_to_the_trash(
    recorded: Workspace, store: Store
) -> None:
    chunks = schema.chunks
    with store.engine.begin() as connection:
        connection.execute(update(chunks).values(first_step=chunks.c.first_step + 6))
    assert "from 0 to 5 are missing" in mended(recorded, "missing").problem
    (take,) = store.takes(1, trashed=True)
    store.restore_take(take.id)
    with store.engine.begin() as connection:
        connection.execute(delete(chunks))
    mended(recorded, "Nothing was recorded")
    assert store.take(take.id).trashed


def test_a_take_that_was_broken_off_is_closed_and_no_reason_to_worry(
    recorded: Workspace, store: Store
) -> None:
    (take,) = store.takes(1)
    with store.engine.begin() as connection:
        connection.execute(update(schema.takes).values(ended_at=None, started_at=0.0))
    assert not mended(recorded, "broken off").wrong
    assert store.takes(1) == [store.take(take.id)]


def test_marks_of_takes_that_are_gone_are_forgotten(recorded: Workspace, store: Store) -> None:
    raw = store.engine.raw_connection()
    raw.execute("PRAGMA foreign_keys=OFF")
    raw.execute("INSERT INTO marks VALUES (7, 77, 8, 0, x'00')")
    raw.commit()
    raw.execute("PRAGMA foreign_keys=ON")
    raw.close()
    found = examine(recorded, mend=True)
    assert about(found, "that are gone").mended
    assert examine(recorded) == []


def test_what_is_no_store_is_told(recorded: Workspace) -> None:
    for name in ("studio.db-wal", "studio.db-shm"):
        (recorded.root / name).unlink(missing_ok=True)
    file = recorded.root / "studio.db"
    data = bytearray(file.read_bytes())
    data[8192:12288] = os.urandom(4096)
    file.write_bytes(bytes(data))
    assert any(one.about == "store" and one.wrong for one in examine(recorded))
    file.write_bytes(b"no database at all" * 1000)
    (found,) = examine(recorded)
    assert "cannot be opened" in found.problem
    assert "evastudio restore" in found.problem


def test_policies_and_what_was_half_written_are_moved_aside(recorded: Workspace) -> None:
    headless.fit(recorded, "Recorded", learner="knn", delay="off", name="good")
    policies = recorded.policies
    (policies / "torn.safetensors").write_bytes((policies / "good.safetensors").read_bytes()[:900])
    half = policies / "good.safetensorsabc.part"
    half.write_bytes(b"half")
    young = policies / "young.safetensorsabc.part"
    young.write_bytes(b"half")
    os.utime(half, (0.0, 0.0))
    found = examine(recorded, mend=True)
    assert all(one.mended for one in found)
    assert "damaged" in about(found, "torn.safetensors").problem
    assert "was being written" in about(found, half.name).problem
    assert examine(recorded) == []
    aside = recorded.root / "aside" / "policies"
    assert {path.name for path in aside.iterdir()} == {"torn.safetensors", half.name}
    assert {path.name for path in policies.iterdir()} == {"good.safetensors", young.name}


def test_what_only_a_person_can_mend_is_told(recorded: Workspace) -> None:
    (recorded.root / "scenes").mkdir()
    (recorded.root / "scenes" / "mine.py").write_text("a scene?")
    crowd = headless.make_scene(recorded, "crowd")
    when = parse_condition("event:impact", crowd)
    switch = Switch(
        (Entry("nobody", when), Entry("crowd-hurried", None)),
        {"name": crowd.name, "version": crowd.version},
    )
    save_switch(switch, recorded.policies / "turns.switch.json")
    recorded.motion.mkdir()
    (recorded.motion / "clips.json").write_text('{"walk": {"file": "gone.glb", "clip": "Walk"}}')
    found = examine(recorded, mend=True)
    assert not any(one.mended for one in found)
    assert "does not run" in about(found, "mine.py").problem
    assert "'nobody'" in about(found, "turns.switch.json").problem
    assert "cannot be played" in about(found, "clips.json").problem


def test_the_command_exits_with_one_until_it_has_mended(recorded: Workspace) -> None:
    shutil.copy(recorded.root / "studio.db", recorded.policies / "odd.safetensors")

    def doctor(*flags: str) -> subprocess.CompletedProcess[str]:
        command = [sys.executable, "-m", "evastudio", "doctor", "-w", str(recorded.root)]
        return subprocess.run([*command, *flags], capture_output=True, text=True, check=False)

    told = doctor()
    assert told.returncode == 1
    assert "policies/odd.safetensors" in told.stdout
    assert "With --mend: It is moved" in told.stdout
    told = doctor("--mend", "--json")
    assert told.returncode == 0
    (found,) = json.loads(told.stdout)
    assert found["mended"]
    assert examine(recorded) == []
