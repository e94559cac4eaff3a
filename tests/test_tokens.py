"""Letting people in and out by the command line."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

from evastudio.demonstrations.store import Store
from evastudio.live.tokens import Role, Tokens
from evastudio.workspace import Workspace


def tokens(place: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-m", "evastudio", "tokens", *arguments, "--workspace", str(place)],
        capture_output=True,
        text=True,
        check=False,
    )


def test_the_environment_gives_the_token_where_a_command_line_would_show_it() -> None:
    for command in ([], ["studio"]):
        done = subprocess.run(
            [sys.executable, "-m", "evastudio", *command],
            capture_output=True,
            text=True,
            check=False,
            env={**os.environ, "EVASTUDIO_TOKEN": "too-short"},
        )
        assert done.returncode == 2
        assert "The token has 9 characters" in done.stderr
        assert "too-short" not in done.stderr


def test_a_token_is_made_listed_without_its_secret_and_revoked(tmp_path: Path) -> None:
    made = tokens(tmp_path, "add", "Ada", "--role", "author")
    assert made.returncode == 0, made.stderr
    (secret,) = [line.strip() for line in made.stdout.splitlines() if line.startswith("    ")]
    with Store(Workspace(tmp_path).store_url) as store:
        found = Tokens(store).holder(secret)
        assert found is not None
        assert (found.name, found.role) == ("Ada", Role.AUTHOR)
        listed = tokens(tmp_path)
        assert "Ada" in listed.stdout
        assert "author" in listed.stdout
        assert secret not in listed.stdout
        assert tokens(tmp_path, "revoke", "Ada").returncode == 0
        assert Tokens(store).holder(secret) is None
    again = tokens(tmp_path, "revoke", "Ada")
    assert again.returncode == 2
    assert "has no token" in again.stderr
