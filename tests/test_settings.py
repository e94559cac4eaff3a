"""How a studio may be run, and what it says of whom that lets in."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from evastudio.errors import InvalidInputError
from evastudio.settings import Settings
from evastudio.workspace import Workspace


def settings(**values: Any) -> Settings:
    return Settings(Workspace(Path("anywhere")), **values)


@pytest.mark.parametrize("host", ["127.0.0.1", "localhost", "::1", "[::1]", "LOCALHOST"])
def test_on_this_machine_alone_nothing_is_exposed(host: str) -> None:
    assert settings(host=host).exposure is None


@pytest.mark.parametrize("host", ["0.0.0.0", "::", "192.0.2.7", "studio.example"])
def test_another_host_is_told_what_it_exposes(host: str) -> None:
    told = settings(host=host).exposure
    assert told is not None
    assert host in told
    assert "token" in told
    assert "nothing is encrypted" in told


def test_there_is_no_studio_without_a_token() -> None:
    assert len(settings().token) >= 32
    assert settings().token != settings().token
    for token in ("", "short", "with a space in it!", "x" * 15):
        with pytest.raises(InvalidInputError, match="token"):
            settings(host="0.0.0.0", token=token)
    assert settings().token not in repr(settings())


@pytest.mark.parametrize(
    ("given", "origin"),
    [
        ("https://studio.example", "https://studio.example"),
        ("https://Studio.Example/", "https://studio.example"),
        ("https://studio.example:443", "https://studio.example"),
        ("http://studio.example:8080", "http://studio.example:8080"),
        ("https://[2001:db8::1]:8443", "https://[2001:db8::1]:8443"),
    ],
)
def test_a_public_address_is_written_as_browsers_do(given: str, origin: str) -> None:
    found = settings(public_url=given)
    assert found.public_url == origin
    assert found.exposure is not None
    assert origin in found.exposure


@pytest.mark.parametrize(
    "given",
    [
        "studio.example",
        "ftp://studio.example",
        "https://",
        "https://studio.example/path",
        "https://me:secret@studio.example",
        "https://studio.example?x=1",
        "https://studio.example:99999",
        "https://[half",
    ],
)
def test_what_is_no_public_address_is_refused(given: str) -> None:
    with pytest.raises(InvalidInputError, match="public address"):
        settings(public_url=given)
