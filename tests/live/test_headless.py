"""Record, clean, fit and evaluate as functions, and what they refuse."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import pytest

import evastudio
from evastudio.demonstrations.replay import replay_take
from evastudio.demonstrations.store import Store
from evastudio.errors import InvalidInputError, NotFoundError, StorageError, StudioError
from evastudio.live import headless
from evastudio.workspace import Workspace
from evastudio.world.scene import world_seeds


@pytest.fixture(scope="module")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> Workspace:
    """A workspace with one short session, number 1."""
    workspace = Workspace(tmp_path_factory.mktemp("recorded"))
    evastudio.record(workspace, "asteroids", "scripted:human", 1.5, seed=4, clock=lambda: 1000.0)
    return workspace


def test_a_scripted_session_has_whole_takes_and_the_last_is_cut(recorded: Workspace) -> None:
    with Store(recorded.store_url) as store:
        session = store.session(1)
        takes = store.takes(1)
    assert (session.pairs, session.seconds, session.created_at) == (1350, 90.0, 1000.0)
    assert [take.seed for take in takes] == world_seeds(4, len(takes))
    assert all(take.outcome for take in takes[:-1])
    assert all(take.pilot == "scripted:human" for take in takes)


def test_every_recorded_take_replays_bit_for_bit(recorded: Workspace) -> None:
    with Store(recorded.store_url) as store:
        for take in store.takes(1):
            scene = headless.make_scene(recorded, "asteroids", take.options)
            data = store.load_take(take.id)
            again = replay_take(scene, take, data)
            for name in data.snapshots.moving:
                assert np.array_equal(data.snapshots[name], again[name])


def test_the_same_seed_records_and_fits_the_same_bytes(tmp_path: Path) -> None:
    files = []
    for name in ("one", "two"):
        workspace = Workspace(tmp_path / name)
        evastudio.record(workspace, "asteroids", minutes=0.5, seed=9, clock=lambda: 0.0)
        fitted = evastudio.fit(workspace, 1, learner="knn", clock=lambda: 0.0)
        files.append(evastudio.load_policy(fitted["file"]))
    assert files[0].fingerprint == files[1].fingerprint
    states = np.random.default_rng(0).normal(size=(50, files[0].state.size))
    assert np.array_equal(files[0].act_states(states), files[1].act_states(states))


def test_cleaned_pairs_are_left_out_of_the_fit_and_undo_brings_them_back(
    recorded: Workspace,
) -> None:
    found = evastudio.clean(recorded, 1, delay="off")
    assert 0 < found["removed"] < found["pairs"] == 1350
    cleaned = evastudio.fit(recorded, 1, learner="knn", delay="off", name="cleaned")
    assert cleaned["pairs"] == 1350 - found["removed"]
    with Store(recorded.store_url) as store:
        store.undo_cleaning(1)
    assert evastudio.fit(recorded, 1, learner="knn", delay="off", name="raw")["pairs"] == 1350


@pytest.mark.parametrize("learner", ["knn", "svr"])
@pytest.mark.parametrize("perception", ["canonical", "paper"])
def test_each_learner_fits_each_perception_and_flies(
    recorded: Workspace, learner: str, perception: str
) -> None:
    fitted = evastudio.fit(recorded, 1, learner=learner, perception=perception, name="flies")
    result = evastudio.evaluate(recorded, ["flies", "straight"], worlds=4, seed=1)
    assert set(result["policies"]) == {"flies", "straight"}
    for figures in result["policies"].values():
        low, high = figures["interval"]
        assert low <= figures["success_rate"] <= high
        assert sum(figures["outcomes"].values()) == 4
    assert fitted["perception"] == perception


def test_a_policy_can_be_written_to_any_file(recorded: Workspace, tmp_path: Path) -> None:
    out = tmp_path / "my policy.safetensors"
    evastudio.fit(recorded, 1, learner="knn", out=out)
    assert evastudio.evaluate(recorded, [str(out)], worlds=2)["worlds"] == 2


@pytest.mark.parametrize(
    ("call", "kind", "says"),
    [
        (lambda w: evastudio.record(w, "asteroid"), NotFoundError, "Did you mean 'asteroids'"),
        (lambda w: evastudio.record(w, "asteroids", "scripted:bold"), NotFoundError, "careful"),
        (lambda w: evastudio.record(w, "asteroids", minutes=0.0), InvalidInputError, "minutes"),
        (
            lambda w: evastudio.record(w, "asteroids", minutes=float("nan")),
            InvalidInputError,
            "minutes",
        ),
        (lambda w: evastudio.clean(w, 99), NotFoundError, "no session '99'"),
        (lambda w: evastudio.clean(w, 1, n_neighbors=5000), InvalidInputError, "5000"),
        (lambda w: evastudio.fit(w, "nobody"), NotFoundError, "nobody"),
        (lambda w: evastudio.fit(w, 1, learner="forest"), NotFoundError, "knn"),
        (lambda w: evastudio.fit(w, 1, perception="xray"), NotFoundError, "canonical"),
        (
            lambda w: evastudio.fit(w, 1, learner="knn", settings={"k": 9999}),
            InvalidInputError,
            "9999",
        ),
        (lambda w: evastudio.fit(w, 1, learner="knn", settings={"kk": 3}), NotFoundError, "kk"),
        (lambda w: evastudio.fit(w, 1, name="../away"), InvalidInputError, "cannot be called"),
        (lambda w: evastudio.evaluate(w, []), InvalidInputError, "at least one"),
        (lambda w: evastudio.evaluate(w, ["ghost"]), NotFoundError, "no policy 'ghost'"),
        (lambda w: evastudio.evaluate(w, ["straight"], worlds=0), InvalidInputError, "0 worlds"),
    ],
)
def test_bad_input_gets_one_clear_sentence(
    recorded: Workspace, call: object, kind: type[StudioError], says: str
) -> None:
    with pytest.raises(kind, match=says) as told:
        call(recorded)  # type: ignore[operator]
    assert "\n" not in str(told.value)


def test_a_session_without_pairs_says_what_to_do(recorded: Workspace) -> None:
    with Store(recorded.store_url) as store:
        scene = headless.make_scene(recorded, "asteroids")
        empty = store.create_session(scene, "Empty", "test", 0.0)
    with pytest.raises(InvalidInputError, match="Record a take first"):
        evastudio.fit(recorded, empty)


def test_a_workspace_that_is_no_folder_is_refused(tmp_path: Path) -> None:
    blocked = tmp_path / "file"
    blocked.write_text("in the way")
    with pytest.raises(StorageError, match="cannot be written"):
        evastudio.sessions(Workspace(blocked))
    assert blocked.read_text() == "in the way"


def test_a_read_only_workspace_is_refused(tmp_path: Path) -> None:
    folder = tmp_path / "closed"
    (folder / "policies").mkdir(parents=True)
    folder.chmod(0o500)
    try:
        if os.access(folder, os.W_OK):  # root writes anywhere: the store's own refusal is tested
            with pytest.raises(StorageError, match="cannot be opened"):
                evastudio.sessions(Workspace(folder, f"sqlite:////proc/{os.getpid()}/studio.db"))
        else:
            with pytest.raises(StorageError, match="permission denied"):
                evastudio.sessions(Workspace(folder))
    finally:
        folder.chmod(0o700)


def test_symbols_of_a_perception_are_cleaned_although_the_scene_acts_in_numbers(
    tmp_path: Path,
) -> None:
    workspace = Workspace(tmp_path)
    evastudio.record(workspace, "crowd", "scripted:shy", 4.0, options={"people": 30.0})
    cleaned = evastudio.clean(workspace, 1)
    assert cleaned["eta"] == []
    assert 0 < cleaned["removed"] < cleaned["pairs"] / 3
    fitted = evastudio.fit(workspace, 1)
    assert fitted["learner"] == "voting"
    assert fitted["pairs"] == cleaned["kept"]
