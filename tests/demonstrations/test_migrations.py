"""Stores of older versions come forward whole, whoever opens them, or stay as they were."""

from __future__ import annotations

import subprocess
import sys
import threading
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest
from alembic.autogenerate import compare_metadata
from alembic.migration import MigrationContext
from sqlalchemy import create_engine, inspect, select

from evastudio.demonstrations import schema
from evastudio.demonstrations.replay import replay_take
from evastudio.demonstrations.store import Store
from evastudio.world.scene import Scene
from tests.demonstrations.old_stores import VERSIONS, put_old_store


@pytest.fixture(params=VERSIONS)
def old(request: pytest.FixtureRequest, store_url: str, tmp_path: Path) -> str:
    """The address of a store that an older version wrote."""
    put_old_store(request.param, store_url, tmp_path)
    return store_url


def differences(store: Store) -> list[object]:
    """What the tables of a store have otherwise than a new one's would."""
    with store.engine.connect() as connection:
        context = MigrationContext.configure(connection, opts={"compare_type": True})
        return list(compare_metadata(context, schema.metadata))


def tables(url: str) -> dict[str, list[str]]:
    engine = create_engine(url)
    seen = inspect(engine)
    found = {name: [c["name"] for c in seen.get_columns(name)] for name in seen.get_table_names()}
    with engine.connect() as connection:
        found["version"] = [str(connection.execute(select(schema.store.c.version)).scalar_one())]
    engine.dispose()
    return found


def test_a_new_store_is_as_the_schema_says(store: Store) -> None:
    assert differences(store) == []


def test_an_old_store_comes_forward_with_all_it_holds(
    old: str, asteroids: Callable[..., Scene]
) -> None:
    with Store(old) as store:
        assert differences(store) == []
        (session,) = store.sessions()
        assert (session.name, session.takes_kept, session.pairs) == ("Kept", 2, 630)
        assert session.cleaning is not None
        assert (session.cleaning.removed, session.cleaning.stale) == (9, False)
        first, second = store.takes(session.id)
        assert (first.outcome, second.outcome, second.note, second.origin) == (
            "crossed",
            None,
            "",
            None,
        )
        scene = asteroids(**first.options)
        data = store.load_take(first.id)
        again = replay_take(scene, first, data)
        for name in data.snapshots.moving:
            assert np.array_equal(again[name], data.snapshots[name])
        third = store.begin_take(
            session.id, scene, "canonical", 1, "test", scene.worlds([1]).fixed, 1.0, key="new"
        )
        assert store.take(third).number == 3
    with Store(old) as store:
        assert store.session("Kept").takes_kept == 3


@pytest.mark.parametrize("version", [1, 3])
def test_studios_that_open_an_old_store_at_once_share_it(
    version: int, store_url: str, tmp_path: Path
) -> None:
    put_old_store(version, store_url, tmp_path)
    together = threading.Barrier(6)

    def open_it(_: int) -> tuple[str, int]:
        together.wait()
        with Store(store_url) as store:
            return store.identity, store.session("Kept").pairs

    with ThreadPoolExecutor(6) as threads:
        assert {pairs for _, pairs in set(threads.map(open_it, range(6)))} == {630}


def test_a_migration_that_is_cut_off_leaves_the_old_store_whole(
    store_url: str, tmp_path: Path
) -> None:
    put_old_store(1, store_url, tmp_path)
    before = tables(store_url)
    code = f"""
import os, signal
from evastudio.demonstrations import migrations, schema
from evastudio.demonstrations.store import Store
migrations.STEPS[schema.VERSION] = lambda _: os.kill(os.getpid(), signal.SIGKILL)
Store({store_url!r})
"""
    assert subprocess.run([sys.executable, "-c", code]).returncode == -9
    assert tables(store_url) == before
    assert before["version"] == ["1"]
    with Store(store_url) as store:
        assert store.session("Kept").pairs == 630
        assert differences(store) == []
