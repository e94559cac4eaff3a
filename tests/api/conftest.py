"""A studio that is attacked."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

if TYPE_CHECKING:
    from tests.conftest import Studio

GROWTH_KB = 400_000
"""What reading something hostile may add to the most memory that the server ever had."""


def peak_kb(studio: Studio) -> int:
    """The most memory that the studio's process has had."""
    told = Path(f"/proc/{studio.process.pid}/status")
    if not told.exists():
        return 0
    (line,) = [one for one in told.read_text().splitlines() if one.startswith("VmHWM")]
    return int(line.split()[1])


@pytest.fixture
def unharmed(studio: Studio) -> Iterator[None]:
    """After every attack the studio answers, and has not swollen."""
    before = peak_kb(studio)
    yield
    assert studio.client.get("/api/v1/me").status_code == 200
    assert peak_kb(studio) - before < GROWTH_KB
