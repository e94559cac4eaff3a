"""A client of the studio that tests share."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from evastudio.client import Studio as Client
from tests.conftest import Studio


@pytest.fixture
def far(studio: Studio) -> Iterator[Client]:
    with Client(studio.url) as made:
        yield made
