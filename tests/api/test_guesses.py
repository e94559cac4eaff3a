"""Attacks on tokens, by guessing and by reading them where they could lie. Each by its name."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import httpx
import pytest

from evastudio.api import throttle
from evastudio.api.throttle import FREE, MOST_ADDRESSES, REFILL_S, Throttle
from evastudio.demonstrations.store import Store
from evastudio.live.tokens import Tokens
from tests.api.served import BEARER, TOKEN, raw, within

API = "/api/v1"


# -- guessing ----------------------------------------------------------------------------------


def test_attack_guessing_tokens(tmp_path: Path) -> None:
    """Guesses are slowed down; whoever was in before, from wherever, is not."""
    with within(tmp_path / "studio") as base, httpx.Client(base_url=base, trust_env=False) as one:
        assert one.get(f"{API}/scenes", headers=BEARER).status_code == 200
        answers = [
            one.get(f"{API}/scenes", headers={"Authorization": f"Bearer guess-{number}"})
            for number in range(FREE + 5)
        ]
        codes = [answer.status_code for answer in answers]
        assert codes[:FREE] == [401] * FREE
        assert codes[-1] == 429
        assert int(answers[-1].headers["retry-after"]) >= 1
        assert one.get("/?token=guess-in-address").status_code == 429
        assert one.get(f"{API}/scenes", headers={"Cookie": "x=1"}).status_code == 401
        assert one.get(f"{API}/scenes", headers=BEARER).status_code == 200


def test_attack_locking_somebody_else_out(tmp_path: Path) -> None:
    """Behind a proxy each address is its own, whatever the guesser writes before it."""
    with (
        within(tmp_path / "studio", behind_proxy="127.0.0.1") as base,
        httpx.Client(base_url=base, trust_env=False) as one,
    ):
        for number in range(FREE + 5):
            wrong = {"Authorization": f"Bearer guess-{number}"}
            said = {**wrong, "X-Forwarded-For": f"203.0.113.{number}, 198.51.100.7"}
            last = one.get(f"{API}/scenes", headers=said).status_code
        assert last == 429
        right = {**BEARER, "X-Forwarded-For": "198.51.100.8"}
        assert one.get(f"{API}/scenes", headers=right).status_code == 200


def test_attack_pretending_to_be_many_addresses(tmp_path: Path) -> None:
    """Without --behind-proxy nobody is believed to speak for others."""
    with within(tmp_path / "studio") as base, httpx.Client(base_url=base, trust_env=False) as one:
        codes = [
            one.get(
                f"{API}/scenes",
                headers={
                    "Authorization": f"Bearer guess-{number}",
                    "X-Forwarded-For": f"203.0.113.{number}",
                    "Forwarded": f"for=203.0.113.{number}",
                    "X-Real-IP": f"203.0.113.{number}",
                },
            ).status_code
            for number in range(FREE + 1)
        ]
        assert codes[-1] == 429


def test_attack_filling_the_throttle() -> None:
    """From however many addresses guesses come, what is remembered of them is bounded."""
    guesses = Throttle()
    for number in range(3 * MOST_ADDRESSES):
        guesses.wrong(f"2001:db8:{number:x}::1", f"digest-{number}", float(number))
    for number in range(3 * throttle.MOST_KNOWN):
        guesses.right(f"digest-{number}")
    assert len(guesses._guesses) == MOST_ADDRESSES
    assert len(guesses._known) == throttle.MOST_KNOWN


def test_a_throttle_forgets_in_time_and_takes_ipv6_by_networks() -> None:
    guesses = Throttle()
    for number in range(FREE):
        assert guesses.wait_s("2001:db8::1", f"{number}", 0.0) == 0.0
        guesses.wrong(f"2001:db8::{number:x}", f"{number}", 0.0)
    assert guesses.wait_s("2001:db8::ffff", "new", 0.0) == pytest.approx(REFILL_S)
    assert guesses.wait_s("2001:db8::ffff", f"{FREE - 1}", 0.0) == 0.0
    assert guesses.wait_s("2001:db8:0:1::1", "new", 0.0) == 0.0
    assert guesses.wait_s("2001:db8::1", "new", REFILL_S) == 0.0
    guesses.right("known")
    assert guesses.wait_s("2001:db8::1", "known", 0.0) == 0.0


# -- where tokens could be read ----------------------------------------------------------------


def test_attack_reading_tokens_from_logs_and_process_lists(tmp_path: Path) -> None:
    """Neither what the studio writes nor what `ps` shows holds a token or a cookie."""
    log = tmp_path / "log"
    folder = tmp_path / "studio"
    command = [sys.executable, "-m", "evastudio", "studio", "--port", "0", "--no-browser"]
    environment = {**os.environ, "EVASTUDIO_TOKEN": TOKEN, "PYTHONUNBUFFERED": "1"}
    with log.open("wb") as errors:
        process = subprocess.Popen(
            [*command, "--json", "--workspace", str(folder)],
            stdout=subprocess.PIPE,
            stderr=errors,
            cwd=tmp_path,
            env=environment,
        )
        assert process.stdout is not None
        base = json.loads(process.stdout.readline())["url"].partition("/?")[0]
        with httpx.Client(base_url=base, trust_env=False) as client:
            cookie = client.get(f"/?token={TOKEN}").headers["set-cookie"]
            client.cookies.clear()
            for path in ("/nothing", f"{API}/sessions/1", f"{API}/policies/x?token={TOKEN}"):
                answer = client.get(path, headers=BEARER)
                assert TOKEN not in answer.text
                assert answer.headers["referrer-policy"] == "no-referrer"
            client.post(f"{API}/sessions", content=b"{", headers=BEARER)
            assert TOKEN not in client.get("/?token=wrong").text
        raw(base, f"GARBAGE {TOKEN}\r\n\r\n".encode())
        shown = Path(f"/proc/{process.pid}/cmdline")
        if shown.exists():
            assert TOKEN.encode() not in shown.read_bytes()
        process.terminate()
        rest = process.stdout.read()
        assert process.wait(timeout=30) == 0
        process.stdout.close()
    value = cookie.partition("=")[2].partition(";")[0].encode()
    for written in (log.read_bytes(), rest):
        assert TOKEN.encode() not in written
        assert value not in written
    for file in folder.rglob("*"):
        if file.is_file():
            assert TOKEN.encode() not in file.read_bytes()


def test_a_code_for_the_browser_is_good_once(tmp_path: Path) -> None:
    """What a process list shows of the browser that the studio opens is no token."""
    from evastudio.api.people import CODE_S, People

    with Store(f"sqlite:///{tmp_path / 'studio.db'}") as store:
        people = People(TOKEN, Tokens(store))
    code = people.code(0.0)
    assert people.redeem("wrong", 1.0) is None
    assert people.redeem(code, 1.0) == TOKEN
    assert people.redeem(code, 1.0) is None
    assert people.redeem(people.code(0.0), CODE_S + 1.0) is None
