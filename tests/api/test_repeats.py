"""A write with an Idempotency-Key happens once, however often and whenever it is sent."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import TYPE_CHECKING

import httpx
import pytest

from evastudio.demonstrations.store import Store
from evastudio.errors import ConflictError, InvalidInputError
from evastudio.live.answers import ABANDONED_S, KEPT_S, Answer, Answers

if TYPE_CHECKING:
    from conftest import Studio

API = "/api/v1"
BODY = {"scene": "asteroids", "name": "Once"}


def post(studio: Studio, key: str, **body: str) -> httpx.Response:
    sent = {**BODY, **body}
    return studio.client.post(f"{API}/sessions", json=sent, headers={"Idempotency-Key": key})


def test_a_repeated_write_is_answered_and_not_done_again(
    start_studio: Callable[..., Studio],
) -> None:
    studio = start_studio()
    first = post(studio, "one")
    assert first.status_code == 201
    again = post(studio, "one")
    assert (again.status_code, again.content) == (201, first.content)
    assert (again.headers["idempotency-replayed"], again.headers["content-type"]) == (
        "true",
        first.headers["content-type"],
    )
    other = post(studio, "one", name="Another")
    assert (other.status_code, "another request" in other.json()["detail"]) == (422, True)
    assert post(studio, "two").json()["id"] != first.json()["id"]
    studio.stop()
    after = start_studio(studio.workspace)
    assert post(after, "one").content == first.content
    assert len(after.client.get(f"{API}/sessions").json()["items"]) == 2


def test_what_was_refused_may_be_tried_again(studio: Studio) -> None:
    for _ in range(2):
        refused = post(studio, "refused", scene="nowhere")
        assert (refused.status_code, refused.headers.get("idempotency-replayed")) == (404, None)
    for key in ("", "x" * 201):
        assert post(studio, key).status_code == 422


def test_of_many_at_once_one_is_done(studio: Studio) -> None:
    with ThreadPoolExecutor(8) as pool:
        answers = list(pool.map(lambda _: post(studio, "many", name="Many at once"), range(16)))
    assert {answer.status_code for answer in answers} <= {201, 409}
    made = {answer.json()["id"] for answer in answers if answer.status_code == 201}
    assert len(made) == 1
    listed = studio.client.get(f"{API}/sessions").json()["items"]
    assert sum(one["name"] == "Many at once" for one in listed) == 1


def test_a_request_that_was_cut_off_is_done_again_after_a_while(store: Store) -> None:
    answers = Answers(store)
    assert answers.begin("key", "digest", 1000.0) is None
    with pytest.raises(ConflictError, match="being done"):
        answers.begin("key", "digest", 1001.0)
    with pytest.raises(InvalidInputError, match="another request"):
        answers.begin("key", "other", 1001.0)
    later = 1001.0 + ABANDONED_S
    assert answers.begin("key", "digest", later) is None
    answers.keep("key", Answer(201, "application/json", b"{}"))
    answers.forget("key")
    assert answers.begin("key", "digest", later + 1.0) == Answer(201, "application/json", b"{}")
    assert answers.begin("key", "other", later + KEPT_S + 1.0) is None
