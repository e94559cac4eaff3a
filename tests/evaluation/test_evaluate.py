"""Evaluation: counts, intervals, and results that repeat."""

import json

import numpy as np
import pytest

from evastudio.errors import InvalidInputError
from evastudio.evaluation.evaluate import decision_us, evaluate
from evastudio.evaluation.interval import wilson_interval
from evastudio.pilots.scripted import find_pilot


def test_wilson_intervals_are_the_published_ones():
    """Newcombe, "Two-sided confidence intervals for the single proportion", 1998, table I."""
    for successes, trials, low, high in (
        (81, 263, 0.2553, 0.3662),
        (15, 148, 0.0624, 0.1605),
        (0, 20, 0.0, 0.1611),
        (1, 29, 0.0061, 0.1718),
    ):
        assert wilson_interval(successes, trials) == pytest.approx((low, high), abs=5e-5)
    assert wilson_interval(20, 20)[1] == 1.0


@pytest.mark.parametrize(("successes", "trials"), [(0, 0), (-1, 5), (6, 5)])
def test_counts_that_cannot_be_have_no_interval(successes, trials):
    with pytest.raises(InvalidInputError, match="cannot be"):
        wilson_interval(successes, trials)


def pilots():
    return {name: find_pilot(name) for name in ("straight", "scripted:human")}


def test_results_do_not_depend_on_chunks_or_processes(asteroids):
    scene = asteroids(density=6.0)
    wanted = None
    for chunk, jobs in ((7, 1), (3, 1), (4, 2)):
        result = evaluate(
            scene,
            pilots(),
            worlds=7,
            seed=3,
            chunk=chunk,
            n_jobs=jobs,
            max_steps=150,
            measure_time=False,
        ).to_json()
        assert wanted is None or result == wanted
        wanted = result


def test_figures_add_up_and_are_json(asteroids):
    told = []
    compared = evaluate(
        asteroids(density=1.0),
        pilots(),
        worlds=5,
        seed=1,
        chunk=2,
        progress=lambda share, doing: told.append(share),
    )
    json.dumps(compared.to_json(), allow_nan=False)
    assert np.all(np.diff(told) > 0)
    assert told[-1] == 1.0
    for name, one in compared.pilots.items():
        assert one.pilot == name
        assert sum(one.counts.values()) == one.worlds == 5
        assert one.counts["crossed"] == one.succeeded.sum()
        assert one.interval[0] <= one.success_rate <= one.interval[1]
        assert one.decision_us is not None
    human = compared.pilots["scripted:human"]
    time_s = human.mean("time_s")
    assert time_s is not None
    assert 36.0 <= time_s < 60.0
    assert compared.pilots["straight"].mean("turn") == 0.0


def test_worlds_that_do_not_end_in_time_are_counted_as_running(asteroids):
    compared = evaluate(asteroids(density=0.1), pilots(), worlds=2, max_steps=5, measure_time=False)
    straight = compared.pilots["straight"]
    assert straight.counts["running"] == 2
    assert straight.mean("time_s") is None


def test_decision_time_is_measured_with_the_clock_that_is_given(asteroids):
    ticks = iter(range(1000))
    pilot = find_pilot("straight")
    assert decision_us(asteroids(), pilot, 1, decisions=9, clock=lambda: next(ticks)) == 1e6


def test_nothing_to_evaluate_is_refused(asteroids):
    with pytest.raises(InvalidInputError, match="at least one pilot"):
        evaluate(asteroids(), {})
    with pytest.raises(InvalidInputError, match="0 worlds"):
        evaluate(asteroids(), pilots(), worlds=0)
