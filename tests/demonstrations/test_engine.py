"""Addresses of stores: what is wrong with one is told in a sentence, and never the password."""

from __future__ import annotations

import contextlib
import subprocess
import sys

import pytest

from evastudio.demonstrations import engine
from evastudio.demonstrations.engine import parse_url
from evastudio.demonstrations.store import Store
from evastudio.errors import StorageError
from tests.postgres import PASSWORD, Postgres


def refused(url: str) -> str:
    with pytest.raises(StorageError, match="session store") as told:
        Store(url)
    return str(told.value)


@pytest.mark.parametrize(
    "url", ["nonsense", "nodb://x/y", "mysql://x/y", "sqlite:////no/such/folder/studio.db", "://"]
)
def test_an_address_that_leads_nowhere_is_refused(url: str) -> None:
    assert "--store" in refused(url) or "give one like" in refused(url)


@pytest.mark.parametrize(
    "url",
    [
        "nodb://someone:hidden@host/base",
        "postgresql+psycopg://someone:hid@hidden@localhost/base",
        "postgresql+psycopg://someone:hid/hidden@localhost/base",
        "postgresql+psycopg://someone:hid:hidden@localhost:1/base",
        "postgresql+psycopg://someone@localhost:1/base?password=hidden",
        "postgresql+psycopg://someone:1@localhost:hidden/base",
    ],
)
def test_a_password_is_not_told(url: str) -> None:
    assert "hidden" not in refused(url).replace("localhost:hidden", "")


def test_a_wrong_password_is_told_and_not_shown(postgres: Postgres) -> None:
    told = refused(postgres.url(password="something else"))
    assert "password authentication failed" in told
    assert "something" not in told
    assert PASSWORD not in told


def test_a_database_that_is_not_there_is_told(postgres: Postgres) -> None:
    assert 'database "nowhere" does not exist' in refused(postgres.url("nowhere"))


def test_a_server_that_is_down_is_told() -> None:
    told = refused("postgresql+psycopg://someone:hidden@127.0.0.1:1/base")
    assert "Check that the server runs" in told


def test_a_database_of_others_is_left_alone(postgres: Postgres, postgres_url: str) -> None:
    name = str(parse_url(postgres_url).database)
    postgres.execute("CREATE TABLE recipes (id integer)", name)
    assert "other tables (recipes)" in refused(postgres_url)


def test_a_database_that_cannot_hold_every_name_is_refused(postgres: Postgres) -> None:
    postgres.execute("CREATE DATABASE latin ENCODING 'LATIN1' LOCALE 'C' TEMPLATE template0")
    assert "ENCODING 'UTF8'" in refused(postgres.url("latin"))
    postgres.execute("DROP DATABASE latin")


def test_a_connection_that_was_cut_is_made_again(postgres: Postgres, postgres_url: str) -> None:
    with Store(postgres_url) as store:
        assert store.sessions() == []
        postgres.execute(
            "SELECT pg_terminate_backend(pid, 5000) FROM pg_stat_activity "
            f"WHERE datname = '{parse_url(postgres_url).database}'"
        )
        assert store.sessions() == []


def test_a_table_that_somebody_locks_is_waited_for_and_then_told(
    postgres: Postgres, postgres_url: str
) -> None:
    soon = "&options=-c%20lock_timeout%3D50"
    with (
        Store(postgres_url + soon) as store,
        postgres.connect(str(parse_url(postgres_url).database)) as other,
        other.transaction(),
    ):
        other.execute("LOCK TABLE sessions IN ACCESS EXCLUSIVE MODE")
        with pytest.raises(StorageError, match="lock timeout"):
            store.sessions()


def test_a_pool_that_is_used_up_is_told(store_url: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(engine, "POOL_WAIT_S", 0.01)
    with Store(store_url) as store, contextlib.ExitStack() as held:
        for _ in range(engine.CONNECTIONS + engine.MORE_CONNECTIONS):
            held.enter_context(store.engine.connect())
        with pytest.raises(StorageError, match="all 32 connections"):
            store.sessions()


def test_without_the_driver_it_says_what_to_install() -> None:
    code = """
import sys
sys.modules["psycopg"] = None
from evastudio.demonstrations.store import Store
from evastudio.errors import StorageError
try:
    Store("postgresql://someone:hidden@127.0.0.1/base")
except StorageError as error:
    print(error)
"""
    told = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True).stdout
    assert "evastudio[postgres]" in told
    assert "hidden" not in told
