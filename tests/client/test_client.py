"""The client against a studio that runs: what it returns, what it raises, what it asks again."""

from __future__ import annotations

import http.server
import threading
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pytest

from evastudio import client
from evastudio.client import Studio as Client
from evastudio.client import connection
from evastudio.client.reading import read
from evastudio.errors import (
    AccessError,
    ConflictError,
    InvalidInputError,
    JobError,
    NotFoundError,
    StudioError,
    UnreachableError,
)
from evastudio.live import headless

if TYPE_CHECKING:
    from conftest import Studio


def test_scenes_say_what_there_is(far: Client) -> None:
    assert {scene.name for scene in far.scenes} >= {"asteroids", "crowd", "street"}
    scene = far.scenes.get("asteroids")
    assert scene.dt_s == pytest.approx(1 / 15)
    assert [view.name for view in scene.perceptions] == ["canonical", "paper"]
    assert scene.action[0].low == -scene.action[0].high  # type: ignore[operator]


def test_a_take_is_made_batch_by_batch_read_thrown_away_and_brought_back(far: Client) -> None:
    session = far.sessions.create("asteroids", "By client", "a client")
    assert session in list(far.sessions.of("asteroids"))
    making = far.takes.begin(session.id, seed=11, options={"density": 0.5}, pilot="me")
    actions = np.random.default_rng(0).uniform(-0.05, 0.05, (30, 2))
    assert making.act(actions) == 30
    assert making.act(actions[:5]) == 5
    take = making.close()
    assert (take.pairs, take.seed, take.session, making.closed) == (35, 11, session.id, True)
    with pytest.raises(ConflictError, match="closed"):
        making.act(actions)
    found = far.takes.recording(take.id)
    assert np.array_equal(found.actions[:30], actions)
    assert found.states.shape == (35, len(making.state))
    assert found.moving["position"].shape == (35, 3)
    assert len(found.fixed["rocks"]) == 1
    assert far.takes.trash(take.id).trashed
    assert [one.id for one in far.takes.of(session.id, trashed=True)] == [take.id]
    assert not far.takes.restore(take.id).trashed
    far.takes.trash(take.id)
    assert far.takes.empty_trash(session.id) == 1
    with pytest.raises(NotFoundError, match="no take"):
        far.takes.get(take.id)


def test_a_take_goes_on_until_its_world_ends(far: Client) -> None:
    session = far.sessions.create("asteroids", "To the end")
    making = far.takes.begin(session.id, seed=1, options={"density": 0.5})
    done = making.act(np.zeros((3000, 2)))
    assert making.closed
    assert done == making.pairs < 3000
    assert far.takes.get(making.id).outcome == making.outcome


def test_work_is_followed_to_its_result_and_policies_are_asked(
    far: Client, studio: Studio, tmp_path: Path
) -> None:
    recorded = far.jobs.wait(far.sessions.record("asteroids", minutes=0.3, name="For a client"))
    assert recorded.result is not None
    made = recorded.result
    number = made["session"]
    told: list[client.Job] = []
    preview = far.jobs.wait(far.sessions.preview_cleaning(number, delay="off", worst=3))
    assert far.sessions.get(number).cleaning is None
    loose, strict = (far.sessions.conflicts(number, threshold=at) for at in (1.4, 0.02))
    assert loose.goes < strict.goes
    worst = strict.items[0]
    far.sessions.judge(number, worst.take, worst.step, "keep")
    kept = far.sessions.conflicts(number, threshold=0.02)
    assert (kept.goes, kept.items[0].verdict) == (strict.goes - 1, "keep")
    far.sessions.judge(number, worst.take, worst.step, None)
    done = far.jobs.wait(far.sessions.clean(number, delay="off"), told.append)
    assert told[-1] == done == far.jobs.get(done.id)
    assert [job.progress for job in told] == sorted(job.progress for job in told)
    session = far.sessions.get(number)
    assert session.cleaning is not None
    assert done.result is not None
    assert session.cleaning.removed == done.result["removed"] == preview.result["removed"]  # type: ignore[index]
    pairs = far.sessions.pairs(number)
    assert (len(pairs.states), pairs.conflicts.sum()) == (session.pairs, session.cleaning.removed)
    assert far.sessions.undo_cleaning(number).cleaning is None
    fitted = far.jobs.wait(
        far.sessions.fit(number, name="by-client", learner="knn", settings={"k": 3}, delay="off")
    )
    assert fitted.result is not None
    policy = far.policies.get("by-client")
    assert (policy.learner, policy.settings["k"], policy.pairs) == ("knn", 3, made["pairs"])
    take = next(far.takes.of(number))
    states = far.takes.recording(take.id).states
    assert far.policies.decide("by-client", states).shape == (len(states), 2)
    found = far.policies.explain("by-client", states[:10])
    assert found.distances[:, 0] == pytest.approx(0.0)
    assert found.takes.shape == found.steps.shape == found.weights.shape

    path = far.policies.download("by-client", tmp_path)
    assert path.name == "by-client.safetensors"
    with pytest.raises(ConflictError):
        far.policies.upload(path)
    assert far.policies.upload(path, replace=True) == far.policies.get("by-client")
    copy = far.policies.upload(path, "by-client-2")
    assert copy.name == "by-client-2"
    assert np.array_equal(
        far.policies.decide("by-client", states), far.policies.decide("by-client-2", states)
    )
    far.policies.delete("by-client-2")
    with pytest.raises(NotFoundError, match="by-client-2"):
        far.policies.get("by-client-2")
    path.write_bytes(b"no policy")
    with pytest.raises(StudioError):
        far.policies.upload(path, "broken")
    parts = far.policies.switch("client-switch", [("by-client", "after:5s"), ("by-client", None)])
    far.jobs.wait(parts)
    kept = far.policies.download("client-switch", tmp_path)
    assert far.policies.upload(kept, "client-switch-2").switches == ["by-client", "by-client"]
    again = far.jobs.again(done.id)
    assert far.jobs.wait(again).result == {**done.result, **far.jobs.get(again.id).result}  # type: ignore[dict-item]
    assert again.id in [job.id for job in far.jobs]


def test_lists_are_read_page_after_page(far: Client) -> None:
    for number in range(3):
        far.sessions.create("street", f"Page {number}")
    pages = far._connection.pages("/sessions", scene="street", limit=2)
    assert [one["id"] for one in pages] == [one.id for one in far.sessions.of("street")]


def test_a_job_that_fails_or_is_cancelled_is_an_error(far: Client, studio: Studio) -> None:
    made = headless.record(studio.workspace, "asteroids", minutes=0.2, session="Failing")
    job = far.sessions.fit(made["session"], learner="knn", settings={"k": -3})
    with pytest.raises(JobError, match="k"):
        far.jobs.wait(job)
    slow = far.sessions.tune(made["session"])
    assert far.jobs.cancel(slow.id).state == "cancelled"
    with pytest.raises(JobError, match="cancelled"):
        far.jobs.wait(slow)


def test_policies_are_compared(far: Client) -> None:
    job = far.evaluations.start(
        "asteroids", ["straight", "asteroids-careful"], worlds=3, options={"density": 0.5}
    )
    done = far.jobs.wait(job)
    assert done.result is not None
    found = far.evaluations.get(done.result["evaluation"])
    again = far.jobs.wait(far.evaluations.again(found.id))
    assert again.result is not None
    assert again.result["same"]
    assert set(found.result["pilots"]) == {"straight", "asteroids-careful"}
    assert found in list(far.evaluations.of("asteroids"))


def test_worlds_go_the_same_whichever_way_they_are_stepped(far: Client) -> None:
    actions = np.random.default_rng(3).uniform(-0.05, 0.05, (50, 4, 2))
    with (
        far.worlds.open("asteroids", [1, 2, 3, 4]) as one,
        far.worlds.open("asteroids", [1, 2, 3, 4]) as other,
        far.worlds.open("asteroids", [9]) as third,
        other.stream() as stream,
    ):
        seen = [one.step(action) for action in actions]
        streamed = list(stream.steps(actions, ahead=7))
        assert len(streamed) == len(seen)
        for a, b in zip(seen, streamed, strict=True):
            assert np.array_equal(a.states, b.states)
            assert (a.outcomes, a.ended) == (b.outcomes, b.ended)
            assert np.array_equal(a.steps, b.steps)
            assert np.array_equal(a.progress, b.progress)
        third.restore(one.save())
        assert third.seeds == (1, 2, 3, 4)
        assert np.array_equal(third.observe().states, seen[-1].states)
        assert np.array_equal(third.play("straight", 3).states, stream.play("straight", 3).states)
        assert np.array_equal(third.reset([5]).states, stream.reset([5]).states)
        assert other.id in [worlds.id for worlds in far.worlds]
        assert far.worlds.get(other.id).seeds == (5,)
    with pytest.raises(NotFoundError, match="no batch of worlds"):
        one.observe()


def test_large_batches_travel_as_arrays(far: Client) -> None:
    with far.worlds.open("crowd", [1, 2, 3]) as worlds, worlds.stream() as stream:
        everybody = np.zeros((3, 60, len(worlds.action)))
        seen = worlds.step(everybody)
        assert seen.states.shape == (3, 60, len(worlds.state))
        assert stream.step(everybody).steps.tolist() == [2, 2, 2]
        assert np.array_equal(stream.observe().states, worlds.observe().states)


def test_a_refusal_in_a_stream_is_an_error_and_the_stream_goes_on(far: Client) -> None:
    with far.worlds.open("asteroids", [1]) as worlds, worlds.stream() as stream:
        good, bad = np.zeros((1, 2)), np.full((1, 2), np.nan)
        with pytest.raises(InvalidInputError, match="NaN"):
            list(stream.steps([good, bad, good, good]))
        assert stream.observe().steps.tolist() == [3]
        for _ in stream.steps([good] * 20):
            break
        with pytest.raises(NotFoundError, match="ghost"):
            stream.play("ghost")
        assert stream.step(good).steps[0] > 4


def test_what_is_lost_is_an_error_too(far: Client) -> None:
    with far.worlds.open("asteroids", [1]) as worlds:
        stream = worlds.stream()
        with pytest.raises(StudioError, match="with"):
            stream.observe()
    with pytest.raises(NotFoundError, match="no batch"), worlds.stream():
        pass


def test_errors_are_those_of_the_studio(far: Client, studio: Studio) -> None:
    with pytest.raises(NotFoundError, match="Did you mean 'asteroids'"):
        far.scenes.get("asteroid")
    with pytest.raises(InvalidInputError, match="printable"):
        far.sessions.create("asteroids", "\n")
    session = far.sessions.create("crowd", "Of the crowd")
    with pytest.raises(ConflictError, match="Choose a session of this scene"):
        far.worlds.open("asteroids", [1], session=session.id)
    with Client(studio.base, "wrong-token-of-nobody") as stranger, pytest.raises(AccessError):
        stranger.scenes.get("asteroids")
    for url, says in (("nowhere", "no address"), (studio.base, "No token")):
        with pytest.raises(InvalidInputError, match=says):
            Client(url)


def test_a_studio_that_is_not_there_is_unreachable(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(connection, "PAUSE_S", 0.0)
    with Client("http://127.0.0.1:9", "x") as nobody:
        with pytest.raises(UnreachableError, match="does not answer"):
            nobody.scenes.get("asteroids")
        with pytest.raises(UnreachableError):
            next(nobody.jobs.follow(1))


def test_answers_of_another_version_are_read_or_refused() -> None:
    told = {"name": "x", "unit": "m", "low": 0.0, "high": None, "new": 1}
    assert read(client.Field, told) == client.Field("x", "m", 0.0, None)
    with pytest.raises(StudioError, match="own version"):
        read(client.Field, {"name": "x"})


class Flaky(http.server.BaseHTTPRequestHandler):
    """Answers every second request, and drops the others."""

    seen: list[tuple[str, str | None]]

    def do_POST(self) -> None:
        self.seen.append((self.path, self.headers["Idempotency-Key"]))
        length = int(self.headers["Content-Length"])
        self.rfile.read(length)
        if len(self.seen) % 2:
            self.close_connection = True
            return
        body = b'{"status": 503}' if len(self.seen) == 2 else b'{"id": 1}'
        self.send_response(503 if len(self.seen) == 2 else 200)
        self.send_header("Content-Length", str(len(body)))
        self.send_header("Retry-After", "0")
        self.end_headers()
        self.wfile.write(body)

    def log_message(self, *_: object) -> None:
        pass


def test_a_write_is_asked_again_under_one_key_and_a_step_never(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Against a server that loses an answer and then is busy."""
    monkeypatch.setattr(connection, "PAUSE_S", 0.0)
    monkeypatch.setattr(connection, "TRIES", 4)
    Flaky.seen = []
    with http.server.HTTPServer(("127.0.0.1", 0), Flaky) as server:
        thread = threading.Thread(target=server.serve_forever)
        thread.start()
        there = connection.Connection(f"http://127.0.0.1:{server.server_port}", "x", 5.0)
        assert there.post("/sessions", {}) == {"id": 1}
        keys = {key for _, key in Flaky.seen}
        assert (len(Flaky.seen), len(keys)) == (4, 1)
        assert keys != {None}
        with pytest.raises(UnreachableError):
            there.send("POST", "/worlds/x/step", json={})
        assert len(Flaky.seen) == 5
        there.close()
        server.shutdown()
        thread.join()
