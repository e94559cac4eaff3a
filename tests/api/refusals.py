"""How the API refuses what is hostile."""

from __future__ import annotations

import httpx

REFUSED = {400, 408, 411, 413, 415, 422}


def refused(answer: httpx.Response, *statuses: int) -> str:
    """The sentence of a refusal, which is a problem."""
    assert answer.status_code in (statuses or REFUSED), answer.text[:200]
    assert answer.headers["content-type"] == "application/problem+json"
    detail: str = answer.json()["detail"]
    assert "Traceback" not in detail
    return detail
