"""Policy files that were changed in whatever way: refused, or policies still."""

import json
import warnings

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from safetensors.numpy import load, save

from evastudio.errors import StorageError
from evastudio.learning.policy_files import load_policy, save_policy
from tests.learning.fitted import SETTINGS, rewritten, some_policy


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
