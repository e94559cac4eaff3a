"""What came of a job."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

import httpx

if TYPE_CHECKING:
    from tests.conftest import Studio


def result_of(studio: Studio, answer: httpx.Response) -> dict[str, Any]:
    """What the job came to that was begun by `answer`, once it is done."""
    assert answer.status_code == 202, answer.text
    told = studio.client.get(f"/api/v1/jobs/{answer.json()['id']}/events", timeout=120.0).text
    last = json.loads(told.strip().rpartition("data: ")[2])
    assert last["state"] == "done", last
    result: dict[str, Any] = last["result"]
    return result
