"""Policy files: what is written is read, and whatever else is read is refused."""

import json
import struct
import warnings
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from safetensors.numpy import load, save

from evastudio.demonstrations.pairs import Pairs
from evastudio.errors import InvalidInputError, NotFoundError, StorageError
from evastudio.learning.cleaning import clean_pairs
from evastudio.learning.fitting import fit_policy
from evastudio.learning.policy import LEARNERS, fingerprint
from evastudio.learning.policy_files import FORMAT, load_policy, read_policy_header, save_policy
from evastudio.workspace import shipped
from evastudio.world.loading import load_scene_file
from evastudio.world.spaces import Symbols

SETTINGS = {
    "knn": {"k": 3, "weights": "distance"},
    "svr": {"C": 5.0},
    "compact": {"bases": 9},
    "local-linear": {"k": 7},
    "sampled": {"k": 4, "link": 0.02},
    "mlp": {"hidden": 5, "iterations": 20},
    "voting": {"k": 3},
    "sampled-voting": {"k": 3},
    "quantized-svr": {"C": 5.0},
    "quantized-knn": {"k": 3},
}
"""Of each learner and of a compact SVR."""


def scene_of(kind):
    """A scene whose actions that kind of learner learns."""
    if kind.endswith("voting") or kind.startswith("quantized"):
        return load_scene_file(Path(__file__).parent.parent / "scenes" / "walker.py")()
    return load_scene_file(shipped() / "scenes" / "asteroids.py")()


def some_pairs(scene, count=60, perception=None):
    rng = np.random.default_rng(count)
    size = scene.perception(perception).state.size
    states = rng.uniform(-1, 1, size=(count, size))
    actions = 0.1 * np.sin(states[:, :2])
    if isinstance(scene.action, Symbols):
        actions = 2.0 + np.sign(states[:, :1])
    return Pairs(states, actions, np.repeat([4, 9], count // 2), np.arange(count))


def some_policy(kind="svr", count=60):
    scene = scene_of(kind)
    pairs = some_pairs(scene, count)
    return fit_policy(
        pairs,
        scene,
        None,
        "svr" if kind == "compact" else kind,
        SETTINGS[kind],
        session=7,
        cleaning=clean_pairs(pairs, scene),
        made_by="evastudio fit 7",
        created="2030-01-02T03:04:05+00:00",
    )


@pytest.fixture(params=list(SETTINGS))
def policy(request):
    return some_policy(request.param)


def states_for(policy, count=40):
    return np.random.default_rng(count).uniform(-1, 1, size=(count, policy.state.size))


def test_every_learner_is_among_them():
    assert set(SETTINGS) - {"compact"} == set(LEARNERS)


def test_a_policy_comes_back_exactly(policy, tmp_path):
    path = save_policy(policy, tmp_path / "made" / "one.safetensors")
    again = load_policy(path)
    states = states_for(policy)
    assert np.array_equal(again.act_states(states), policy.act_states(states))
    drawn = [one.act_states(states, np.random.default_rng(3)) for one in (again, policy)]
    assert np.array_equal(*drawn)
    for name in ("pairs", "distances", "weights", "agreement"):
        was, now = (getattr(one.explain(states), name) for one in (policy, again))
        assert (was is now is None) or np.array_equal(was, now), name
    assert np.array_equal(again.moments, policy.moments)
    assert again.describe() == policy.describe()
    assert (again.state, again.action) == (policy.state, policy.action)
    assert (again.session, again.takes, again.pairs) == (7, (4, 9), policy.pairs)
    assert save_policy(again, tmp_path / "two.safetensors").read_bytes() == path.read_bytes()
    assert [file.name for file in path.parent.iterdir()] == ["one.safetensors"]


def test_the_header_can_be_read_alone(policy, tmp_path):
    path = save_policy(policy, tmp_path / "one.safetensors")
    header = read_policy_header(path)
    assert header["learner"] == policy.learner_name
    assert header["made_by"] == "evastudio fit 7"
    assert header["cleaning"]["pairs"] == 60
    if isinstance(policy.action, Symbols):
        assert header["action"] == {"symbols": ["stand", "east", "north", "west", "south"]}
    else:
        assert [field["name"] for field in header["action"]] == ["theta", "phi"]


def test_any_truncation_is_refused(policy, tmp_path):
    path = save_policy(policy, tmp_path / "one.safetensors")
    data = path.read_bytes()
    for size in [*range(0, 40), *range(40, len(data), 211), len(data) - 1]:
        path.write_bytes(data[:size])
        with pytest.raises(StorageError, match=r"not a policy that can be used"):
            load_policy(path)


@pytest.fixture(scope="module")
def written(tmp_path_factory):
    """A file of each learner, and the folder to write its mutations to."""
    folder = tmp_path_factory.mktemp("policies")
    files = [
        save_policy(some_policy(kind, 44), folder / f"{kind}.safetensors") for kind in SETTINGS
    ]
    return [file.read_bytes() for file in files], folder


@settings(max_examples=400, deadline=None)
@given(st.data())
def test_any_mutation_is_refused_or_still_a_policy(written, data):
    files, folder = written
    mutated = bytearray(data.draw(st.sampled_from(files)))
    header = 8 + int.from_bytes(mutated[:8], "little")
    for _ in range(data.draw(st.integers(1, 4))):
        end = data.draw(st.sampled_from([8, header, len(mutated)]))
        place = data.draw(st.integers(0, end - 1))
        kind = data.draw(st.sampled_from(["byte", "digit", "cut", "insert"]))
        if kind == "byte":
            mutated[place] = data.draw(st.integers(0, 255))
        elif kind == "digit":
            mutated[place] = data.draw(st.sampled_from(b'0123456789-e.,"[]{}'))
        elif kind == "cut":
            del mutated[place : place + data.draw(st.integers(1, 9))]
        else:
            mutated[place:place] = data.draw(st.binary(min_size=1, max_size=9))
        if not mutated:
            break
    path = folder / "mutated.safetensors"
    path.write_bytes(bytes(mutated))
    refused_or_whole(path)


def refused_or_whole(path):
    """The file is refused, or it is a policy that decides and explains."""
    try:
        policy = load_policy(path)
    except StorageError:
        return
    actions = policy.act_states(np.ones((2, policy.state.size)))
    policy.action.check(actions, "actions")
    assert actions.shape == (2, policy.action.size)
    reasons = policy.explain(np.ones((2, policy.state.size)))
    assert np.isfinite(reasons.weights).all()
    if policy.moments is not None:
        assert policy.moments[reasons.pairs].shape == (*reasons.pairs.shape, 2)


def rewritten(path, change):
    """The file at `path` with its description put through `change`."""
    data = path.read_bytes()
    size = int.from_bytes(data[:8], "little")
    outer = json.loads(data[8 : 8 + size])
    header = json.loads(outer["__metadata__"]["evastudio"])
    change(header)
    outer["__metadata__"]["evastudio"] = json.dumps(header)
    packed = json.dumps(outer).encode()
    packed += b" " * (-len(packed) % 8)
    path.write_bytes(struct.pack("<Q", len(packed)) + packed + data[8 + size :])
    return path


NUMBERS = st.one_of(
    st.sampled_from([0, 1, -1, 2**31, 2**63, 10**400, 1e308, -1e-308, float("nan"), float("inf")]),
    st.integers(),
    st.floats(),
)
ODD = st.one_of(NUMBERS, st.none(), st.booleans(), st.text(max_size=3), st.just([]), st.just({}))


@settings(max_examples=200, deadline=None)
@given(st.data())
def test_any_other_description_is_refused_or_still_a_policy(written, data):
    files, folder = written
    path = folder / "described.safetensors"
    path.write_bytes(data.draw(st.sampled_from(files)))

    def change(header):
        place = header
        for _ in range(data.draw(st.integers(1, 3))):
            keys = sorted(place) if isinstance(place, dict) else range(len(place))
            if not keys:
                return
            key = data.draw(st.sampled_from(keys))
            if not isinstance(place[key], dict | list) or data.draw(st.booleans()):
                place[key] = data.draw(ODD)
                return
            place = place[key]

    refused_or_whole(rewritten(path, change))


EXTREMES = (0, 1, -1, 1e59, -1e59, 1e-59, 1e-300, np.nan, np.inf, 65000, 2**31 - 1)
DTYPES = (np.float16, np.float32, np.int8, np.uint64, np.int64, np.bool_)


def damaged(array, kind, rng):
    """A copy of `array` that is not as it was."""
    if kind == "shape":
        return array.reshape([(-1,), (1, -1), (-1, 1)][rng.integers(3)])
    if kind == "rows":
        return array[: rng.integers(5)]
    raw = bytearray(array.tobytes())
    if kind == "bits" and raw:
        raw[rng.integers(len(raw))] ^= int(rng.integers(1, 256))
        return np.frombuffer(raw, array.dtype).reshape(array.shape)
    with warnings.catch_warnings(), np.errstate(all="ignore"):
        warnings.simplefilter("ignore")
        if kind == "dtype":
            return array.astype(rng.choice(DTYPES))
        changed = array.copy()
        value = np.float64(rng.choice(EXTREMES)).astype(array.dtype)
    changed.flat[:: 1 if rng.random() < 0.5 else max(1, array.size - 1)] = value
    return changed


@settings(max_examples=300, deadline=None)
@given(st.integers(0, 2**32))
def test_any_other_arrays_are_refused_or_still_a_policy(written, seed):
    """Numbers far out, NaN in narrow arrays, negative indices, other shapes and dtypes."""
    files, folder = written
    rng = np.random.default_rng(seed)
    original = files[rng.integers(len(files))]
    size = int.from_bytes(original[:8], "little")
    metadata = json.loads(original[8 : 8 + size])["__metadata__"]
    arrays = load(original)
    for _ in range(rng.integers(1, 4)):
        kind = rng.choice(["number", "shape", "dtype", "rows", "bits", "gone"])
        chosen = sorted(arrays) if kind == "rows" else [rng.choice(sorted(arrays))]
        for key in chosen:
            arrays[key] = damaged(arrays[key], kind, rng)
        if kind == "gone" and len(arrays) > 1:
            del arrays[key]
    path = folder / "arrays.safetensors"
    tidy = {key: np.ascontiguousarray(array) for key, array in arrays.items()}
    path.write_bytes(save(tidy, metadata))
    refused_or_whole(path)


@pytest.mark.parametrize(
    ("change", "says"),
    [
        (lambda header: header.update(format=FORMAT + 1), "Install a newer EVA Studio"),
        (lambda header: header.update(format="new"), "its format is 'new'"),
        (lambda header: header.update(learner="forest"), "'forest' is not known"),
        (lambda header: header["settings"].update(k=0, C=0.0), "settings|k is 0"),
        (lambda header: header.update(session={}), "'session' is no number or name"),
        (lambda header: header.update(state={"symbols": ["a", "b"]}), "not made of numbers"),
        (lambda header: header.update(action={"symbols": ["a"]}), "1 symbols"),
        (lambda header: header["state"].pop(), "has shape"),
        (lambda header: header.update(state=[]), "no fields"),
        (lambda header: header.pop("scene"), "not whole"),
        (lambda header: header["scene"].update(version="one"), "no name or version"),
        (lambda header: header.update(takes=["x"]), "not whole"),
        (lambda header: header.update(perception=3), "'perception' is not text"),
        (lambda header: header.update(cleaning=[1]), "'cleaning' is not a report"),
    ],
)
def test_a_description_that_makes_no_sense_is_named(policy, tmp_path, change, says):
    path = rewritten(save_policy(policy, tmp_path / "one.safetensors"), change)
    with pytest.raises(StorageError, match=says):
        load_policy(path)


@pytest.mark.parametrize("version", [1, 2])
def test_a_file_of_an_older_format_is_still_read(tmp_path, version):
    """An SVR then kept its support vectors alone, and no file had moments."""
    policy = some_policy()
    for name in ("states_", "actions_", "duals_"):
        delattr(policy.learner, name)
    path = save_policy(replace(policy, moments=None), tmp_path / "one.safetensors")

    def age(header):
        header["format"] = version
        if version == 1:
            del header["settings"]["bases"]

    again = load_policy(rewritten(path, age))
    states = states_for(policy)
    assert np.array_equal(again.act_states(states), policy.act_states(states))
    assert again.settings == policy.settings
    assert again.moments is None
    assert again.explain(states).agreement is None
    with pytest.raises(InvalidInputError, match="Fit it again from its session"):
        again.learner.remove_pairs([0])


def test_a_compact_form_of_format_2_is_still_read(tmp_path):
    """It held the numbers of its bases among the pairs, where now their moments stand."""
    policy = some_policy("compact")
    path = save_policy(policy, tmp_path / "one.safetensors")
    data = path.read_bytes()
    outer = json.loads(data[8 : 8 + int.from_bytes(data[:8], "little")])
    arrays = load(data)
    del arrays["moments"]
    arrays["support"] = policy.learner.support_.astype(np.int32)
    path.write_bytes(save(arrays, outer["__metadata__"]))
    again = load_policy(rewritten(path, lambda header: header.update(format=2)))
    states = states_for(policy)
    assert np.array_equal(again.act_states(states), policy.act_states(states))
    assert np.array_equal(again.learner.kept, policy.learner.kept)


def test_reasons_lead_to_the_moments_that_were_shown(policy, tmp_path):
    """Asked about a state that was shown, the nearest pair is that moment's; or a base is."""
    shown = some_pairs(scene_of(policy.learner_name))
    again = load_policy(save_policy(policy, tmp_path / "one.safetensors"))
    rows = again.moments[:, 1]
    assert np.array_equal(again.moments[:, 0], shown.takes[rows])
    asked = shown.states[rows]
    reasons = again.explain(asked)
    assert np.array_equal(again.moments[reasons.pairs[:, 0], 1], rows)
    assert reasons.distances[:, 0] == pytest.approx(0.0, abs=2e-3)  # compact: float16


def test_other_files_are_refused(tmp_path):
    from safetensors.numpy import save_file

    foreign = tmp_path / "foreign.safetensors"
    save_file({"weight": np.zeros(3)}, foreign)
    text = tmp_path / "text.safetensors"
    text.write_text("hello, this is no policy at all")
    for path in (foreign, text):
        for read in (load_policy, read_policy_header):
            with pytest.raises(StorageError, match="not a policy that can be used"):
                read(path)
    with pytest.raises(StorageError, match="could not be read: No such file"):
        load_policy(tmp_path / "missing.safetensors")


def test_a_place_that_cannot_be_written_is_named(policy, tmp_path):
    blocker = tmp_path / "file"
    blocker.write_text("")
    with pytest.raises(StorageError, match="could not be written"):
        save_policy(policy, blocker / "one.safetensors")


def test_arrays_that_are_not_finite_are_refused(policy, tmp_path):
    policy.learner.scale_ = policy.learner.scale_ * np.nan
    with pytest.raises(StorageError, match="'scale' holds values that make no sense"):
        load_policy(save_policy(policy, tmp_path / "one.safetensors"))


def test_the_fingerprint_changes_with_the_pairs(asteroids):
    pairs = some_pairs(asteroids())
    kept = pairs.keep(np.arange(len(pairs)) != 3)
    assert fingerprint(pairs) == fingerprint(some_pairs(asteroids()))
    assert fingerprint(pairs) != fingerprint(kept)


def test_fitting_refuses_what_it_cannot_use(asteroids):
    scene = asteroids()
    pairs = some_pairs(scene)
    with pytest.raises(NotFoundError, match="Did you mean 'svr'"):
        fit_policy(pairs, scene, "canonical", "svm")
    with pytest.raises(NotFoundError, match="Did you mean 'canonical'"):
        fit_policy(pairs, scene, "canonicle")
    with pytest.raises(NotFoundError, match="no setting 'k' of learner 'svr'"):
        fit_policy(pairs, scene, "canonical", "svr", {"k": 3})
    with pytest.raises(InvalidInputError, match="no pairs"):
        fit_policy(pairs.keep(np.zeros(60, dtype=bool)), scene)
    with pytest.raises(InvalidInputError, match="expected \\(rows, 8\\)"):
        fit_policy(pairs, scene, "paper")
    with pytest.raises(InvalidInputError, match="looked at 60 pairs"):
        fit_policy(pairs.keep(np.arange(60) < 50), scene, cleaning=clean_pairs(pairs, scene))
    with pytest.raises(InvalidInputError, match="only 60"):
        fit_policy(pairs, scene, learner="knn", settings={"k": 61})


def test_too_few_pairs_to_clean_are_refused_in_plain_words(asteroids):
    scene = asteroids()
    for count, says in (
        (0, "no pairs to clean"),
        (
            40,
            "its 25 nearest others from other moments, which needs 44 pairs, and there are only 40",
        ),
    ):
        with pytest.raises(InvalidInputError, match=says):
            clean_pairs(some_pairs(scene).keep(np.arange(60) < count), scene)


def test_fitting_and_cleaning_tell_their_progress(asteroids):
    told = []
    scene = asteroids()
    cleaning = clean_pairs(some_pairs(scene), scene, progress=lambda *news: told.append(news))
    fit_policy(some_pairs(scene), scene, progress=lambda *news: told.append(news))
    shares = [share for share, _ in told]
    assert shares == [0.0, 1.0, 0.0, 0.5, 1.0, 1.0]
    assert cleaning.report()["kept"] + cleaning.report()["conflicts"] == 60
    assert json.dumps(cleaning.report())
