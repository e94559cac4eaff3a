"""A backup holds what a store held at one moment; a restore writes nothing over."""

from __future__ import annotations

import json
import threading
import zipfile
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from sqlalchemy import update

from evastudio.demonstrations import schema
from evastudio.demonstrations.recorder import Recorder
from evastudio.demonstrations.replay import replay_take
from evastudio.demonstrations.store import Store
from evastudio.errors import ConflictError, InvalidInputError, StorageError
from evastudio.live.backups import backup, restore
from evastudio.workspace import Workspace
from evastudio.world.scene import Scene
from tests.demonstrations.old_stores import put_old_store


@pytest.fixture
def scene(asteroids: Callable[..., Scene]) -> Scene:
    return asteroids(density=0.5)


@pytest.fixture
def place(tmp_path: Path, store_url: str, scene: Scene) -> Workspace:
    """A workspace with a session of two takes, one of them in the trash, and files."""
    made = Workspace(tmp_path / "work", store_url).ready()
    with Store(store_url) as store:
        session = store.create_session(scene, "Kept", "test", 0.0)
        recorder = Recorder(store, session)
        for seed in (1, 2):
            fly(recorder, scene, seed, 30)
        recorder.discard(9.0)
        recorder.close(9.0)
        store.save_cleaning(session, {}, {1: np.arange(30) % 7 == 0}, 3.0)
    (made.root / "scenes").mkdir()
    (made.root / "scenes" / "own.py").write_text("scene = 'mine'\n")
    (made.root / "scenes" / "__pycache__").mkdir()
    (made.root / "scenes" / "__pycache__" / "own.pyc").write_bytes(b"left out")
    (made.root / "policies" / "mine.safetensors").write_bytes(b"a policy's bytes")
    return made


def fly(recorder: Recorder, scene: Scene, seed: int, steps: int) -> None:
    snapshot = scene.worlds([seed])
    recorder.begin(scene, snapshot, seed, "test", float(seed))
    for _ in range(steps):
        actions = np.full((1, 2), 0.01)
        recorder.add(scene.perception().perceive(snapshot).states, actions, snapshot)
        snapshot = scene.step(snapshot, actions)
    recorder.end("crossed", 5.0)


def test_a_backup_moves_between_databases_with_all_it_holds(
    place: Workspace, tmp_path: Path, scene: Scene, request: pytest.FixtureRequest
) -> None:
    made = backup(place, tmp_path / "kept.zip", clock=lambda: 12.0)
    assert (made["sessions"], made["takes"], made["pairs"], made["files"]) == (1, 2, 60, 2)
    sqlite = place.store_url.startswith("sqlite")
    url = str(request.getfixturevalue("postgres_url")) if sqlite else None
    there = Workspace(tmp_path / "other", url)
    assert restore(there, tmp_path / "kept.zip") == made
    with Store(place.store_url) as old, Store(there.store_url) as new:
        assert new.identity == old.identity
        assert new.sessions() == old.sessions()
        assert new.takes(1, None) == old.takes(1, None)
        for take in old.takes(1, None):
            before, after = old.load_take(take.id), new.load_take(take.id)
            assert np.array_equal(before.states, after.states)
            again = replay_take(scene, take, after)
            for name in again.moving:
                assert np.array_equal(again[name], after.snapshots[name])
        third = new.begin_take(1, scene, "canonical", 1, "test", {}, 1.0)
        assert third == 3
        assert new.create_session(scene, "Next", "test", 1.0) == 2
    assert (there.root / "scenes" / "own.py").read_text() == "scene = 'mine'\n"
    assert (there.policies / "mine.safetensors").read_bytes() == b"a policy's bytes"
    assert not list(there.root.glob("*/__pycache__"))
    assert not [path for path in there.root.iterdir() if path.name.startswith(".restore")]


def test_a_backup_made_while_a_take_runs_is_of_one_moment(
    place: Workspace, tmp_path: Path, scene: Scene
) -> None:
    stop, begun = threading.Event(), threading.Event()

    def fly_on() -> None:
        with Store(place.store_url) as store:
            recorder = Recorder(store, 1)
            seed = 10
            while not stop.is_set():
                fly(recorder, scene, seed, 40)
                written = threading.Event()
                recorder.settle(written.set)
                assert written.wait(30.0)
                begun.set()
                seed += 1
            recorder.close(1.0)
            assert recorder.problem is None

    flying = threading.Thread(target=fly_on)
    flying.start()
    try:
        assert begun.wait(30.0)
        backups = [backup(place, tmp_path / f"{number}.zip") for number in range(3)]
    finally:
        stop.set()
        flying.join()
    for number, made in enumerate(backups):
        there = Workspace(tmp_path / f"there-{number}")
        restore(there, tmp_path / f"{number}.zip")
        with Store(there.store_url) as store:
            takes = store.takes(1, None)
            assert sum(take.pairs for take in takes) == made["pairs"] > 60
            assert [take.number for take in takes] == list(range(1, len(takes) + 1))
            for take in takes:
                if take.pairs:
                    assert len(store.load_take(take.id).actions) == take.pairs
            assert all(take.pairs == 40 for take in takes[2:-1])


def test_a_backup_of_an_older_version_is_restored(tmp_path: Path) -> None:
    old = f"sqlite:///{tmp_path / 'old.db'}"
    put_old_store(1, old, tmp_path)
    about = {"evastudio_backup": 1, "made_at": 0, "sessions": 1, "takes": 2, "pairs": 630}
    with zipfile.ZipFile(tmp_path / "old.zip", "x") as made:
        made.writestr("backup.json", json.dumps({**about, "files": 0}))
        made.write(tmp_path / "old.db", "studio.db")
    there = Workspace(tmp_path / "there")
    restore(there, tmp_path / "old.zip")
    with Store(there.store_url) as store:
        assert store.session("Kept").pairs == 630


def test_nothing_is_written_over(place: Workspace, tmp_path: Path) -> None:
    file = tmp_path / "kept.zip"
    backup(place, file)
    with pytest.raises(ConflictError, match="there already"):
        backup(place, file)
    with pytest.raises(ConflictError, match="sessions of its own"):
        restore(place, file)
    there = Workspace(tmp_path / "there").ready()
    (there.policies / "mine.safetensors").write_bytes(b"another")
    with pytest.raises(ConflictError, match=r"policies/mine\.safetensors"):
        restore(there, file)
    assert (there.policies / "mine.safetensors").read_bytes() == b"another"
    assert not (there.root / "scenes").exists()
    assert not (there.root / "studio.db").exists()


def test_a_restore_that_was_cut_off_is_made_again(place: Workspace, tmp_path: Path) -> None:
    file = tmp_path / "kept.zip"
    backup(place, file)
    there = Workspace(tmp_path / "there").ready()
    (there.policies / "mine.safetensors").write_bytes(b"a policy's bytes")
    Store(there.store_url).close()
    restore(there, file)
    with Store(there.store_url) as store:
        assert store.session("Kept").takes_kept == 1


@pytest.fixture
def small(tmp_path: Path) -> Path:
    """A backup of an empty workspace."""
    backup(Workspace(tmp_path / "small"), tmp_path / "small.zip")
    return tmp_path / "small.zip"


def test_a_damaged_backup_is_refused(small: Path, tmp_path: Path) -> None:
    whole = small.read_bytes()
    middle = len(whole) // 2
    damaged = {
        "cut": whole[:middle],
        "bent": whole[:middle] + bytes([whole[middle] ^ 255]) + whole[middle + 1 :],
        "text": b"not a backup at all",
        "nothing": b"",
    }
    for name, data in damaged.items():
        path = tmp_path / name
        path.write_bytes(data)
        with pytest.raises(StorageError, match=r"no backup, or damaged"):
            restore(Workspace(tmp_path / "there"), path)
    assert not (tmp_path / "there" / "studio.db").exists()


@pytest.mark.parametrize(
    "name",
    [
        "../outside.py",
        "/etc/outside",
        "scenes/../../outside.py",
        "scenes\\..\\outside.py",
        "elsewhere/file",
        "scenes/",
        "outside.py",
    ],
)
def test_a_file_that_belongs_elsewhere_is_refused(small: Path, tmp_path: Path, name: str) -> None:
    with zipfile.ZipFile(small, "a") as opened:
        opened.writestr(zipfile.ZipInfo(name), "outside")
    with pytest.raises(StorageError, match="no backup of this studio"):
        restore(Workspace(tmp_path / "there"), small)
    assert [path.name for path in (tmp_path / "there").rglob("*")] == ["policies"]


def test_other_files_and_newer_backups_are_refused(small: Path, tmp_path: Path) -> None:
    there = Workspace(tmp_path / "there")
    with pytest.raises(InvalidInputError, match="no file"):
        restore(there, tmp_path / "nowhere.zip")
    other = tmp_path / "other.zip"
    with zipfile.ZipFile(other, "x") as made:
        made.writestr("readme.txt", "something else")
    with pytest.raises(StorageError, match="no backup of this studio"):
        restore(there, other)
    for about, said in (({"evastudio_backup": 2}, "format 2"), ([], "no backup"), ("x", "no bac")):
        newer = tmp_path / "newer.zip"
        with zipfile.ZipFile(newer, "w") as made:
            made.writestr("backup.json", json.dumps(about))
            made.writestr("studio.db", b"")
        with pytest.raises(StorageError, match=said):
            restore(there, newer)
    with zipfile.ZipFile(newer, "w") as made:
        made.writestr("backup.json", json.dumps({"evastudio_backup": 1}))
        made.writestr("studio.db", b"no database" * 1000)
    with pytest.raises(StorageError, match="cannot be opened"):
        restore(there, newer)
    later = tmp_path / "later.db"
    with Store(f"sqlite:///{later}") as store, store.engine.begin() as connection:
        connection.execute(update(schema.store).values(version=99))
    with zipfile.ZipFile(newer, "w") as made:
        made.writestr("backup.json", json.dumps({"evastudio_backup": 1}))
        made.write(later, "studio.db")
    with pytest.raises(StorageError, match="version 99"):
        restore(there, newer)


def test_a_folder_that_is_not_there_is_told(tmp_path: Path) -> None:
    with pytest.raises(InvalidInputError, match="no folder"):
        backup(Workspace(tmp_path / "small"), tmp_path / "nowhere" / "kept.zip")
