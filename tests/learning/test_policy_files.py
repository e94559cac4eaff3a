"""Policy files: what is written is read, and whatever else is read is refused."""

import json
from dataclasses import replace

import numpy as np
import pytest
from safetensors.numpy import load, save

from evastudio.errors import InvalidInputError, StorageError
from evastudio.learning.policy import LEARNERS
from evastudio.learning.policy_files import FORMAT, load_policy, read_policy_header, save_policy
from evastudio.world.spaces import Symbols
from tests.learning.fitted import (
    SETTINGS,
    rewritten,
    scene_of,
    some_pairs,
    some_policy,
    states_for,
)


@pytest.fixture(params=list(SETTINGS))
def policy(request):
    return some_policy(request.param)


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
