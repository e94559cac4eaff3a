"""Tuning: settings chosen on whole takes that were held out, and a report of what was measured.

One setting after the other is tried over its values, the others at their best so far. What was
found is then believed only where the takes agree (`trials.choose`), so noise picks no odd
settings. The error reported is not that of the winner, which was picked for being low: each take
is judged by the settings that the other takes would have chosen. It is still measured on single
decisions. What becomes of a character that lives with its own decisions, only `evaluate` tells.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from sklearn.dummy import DummyClassifier, DummyRegressor
from sklearn.linear_model import Ridge, RidgeClassifier
from sklearn.pipeline import make_pipeline
from sklearn.preprocessing import StandardScaler

from evastudio.demonstrations.pairs import Pairs
from evastudio.errors import InvalidInputError, not_found
from evastudio.learning.candidates import GRIDS, THRESHOLDS, Candidate, others, tuned_learners
from evastudio.learning.cleaning import N_NEIGHBORS, Progress, silent
from evastudio.learning.compiled import ensure_compiled
from evastudio.learning.holdout import Mask
from evastudio.learning.perceived import Perceived, compare_perceptions
from evastudio.learning.trials import Examiner, Trial, choose, is_better
from evastudio.learning.tuning_report import Row, Tuning
from evastudio.world.compiled import is_compiled
from evastudio.world.scene import Perception, Scene
from evastudio.world.spaces import finite_rows

AUTO = "auto"
"""The learner's name that stands for "choose for me"."""
JOBS = 2
LEAST = 10
"""Pairs that must be left to learn from."""
COARSE = 3000
"""Support vector machines learn from whole takes of about so many pairs while the grid is gone
through; the best few are then tried on all."""
FINALISTS = 3


def tune(
    pairs: Pairs,
    scene: Scene,
    learner: str = AUTO,
    *,
    perception: str | Perception | None = None,
    threshold: float | str | None = None,
    n_neighbors: int = N_NEIGHBORS,
    views: Sequence[Perceived] = (),
    n_jobs: int = JOBS,
    progress: Progress = silent,
) -> Tuning:
    """The settings that serve best on held-out takes: of one `learner`, or of all that suit.

    `pairs` are all kept ones, perceived through `perception`. `threshold` and `n_neighbors` are
    those of the cleaning that the session has had; without a threshold it has had none, and whether
    to clean is among the choices. `views`
    are the same takes under other perceptions, the first being that of `pairs`. The same pairs
    give the same report, whatever `n_jobs`. Raises InvalidInputError for fewer than two takes or
    too few pairs, NotFoundError for an unknown perception or a learner that cannot be tuned.
    """
    view = scene.perception(perception)
    names = tuned_learners(scene.chosen(view))
    if learner != AUTO and learner not in names:
        raise not_found("learner", learner, (AUTO, *names), "that can be tuned")
    finite_rows(pairs.states, pairs.states.shape[1], "states of the pairs")
    finite_rows(pairs.actions, pairs.actions.shape[1], "actions of the pairs")
    wanted = names if learner == AUTO else (learner,)
    steps = _Steps(progress, sum(len(GRIDS[name]) + 2 for name in wanted) + 5)
    examiner = Examiner(pairs, scene, view, n_neighbors=n_neighbors, n_jobs=n_jobs, progress=steps)
    least = _least(examiner, wanted, None)
    if not is_compiled():  # the report must not depend on what was compiled before
        progress(0.0, "Getting ready, once on this machine: half a minute")
        ensure_compiled()
    if threshold is not None:
        least = _least(examiner, wanted, threshold)
    baselines = _baselines(examiner, names)
    tried: list[Trial] = []
    for name in wanted:
        if Candidate(name).neighbors <= least:
            tried += _search(examiner, name, threshold, least)
    uncleaned = choose(tried)
    cleaned = _with_cleaning(examiner, uncleaned.candidate, threshold)
    if threshold is None:
        tried += cleaned
    chosen = choose(tried)
    learning = _learning_curve(examiner, chosen)
    seen = compare_perceptions(views, chosen.candidate.make(), examiner)
    unseen = np.empty(len(pairs))
    for take in np.unique(pairs.takes):
        rows = pairs.takes == take
        unseen[rows] = choose(tried, int(take)).wrong[rows]
    honest = Trial(chosen.candidate, unseen, pairs.takes, chosen.symbols)
    progress(1.0, "Tuned")
    return _report(
        pairs, honest, chosen, tried, baselines, uncleaned, cleaned, threshold, learning, seen
    )


class _Steps:
    """Shares the progress among parts of the work that are equally long, more or less."""

    def __init__(self, progress: Progress, count: int) -> None:
        self._progress, self._count, self._done = progress, count, 0

    def __call__(self, share: float, doing: str) -> None:
        self._progress((self._done + share) / self._count, doing)
        self._done += share >= 1.0


def _least(examiner: Examiner, wanted: Sequence[str], threshold: float | str | None) -> int:
    """How many pairs there are at least to learn from.

    Raises InvalidInputError where they are too few for every one of the learners `wanted`.
    """
    least = int(examiner.taught(threshold).min())
    needed = max(LEAST, min(Candidate(name).neighbors for name in wanted))
    if least < needed:
        raise InvalidInputError(
            f"Without the take held out there are only {least} pairs to learn from, and at least "
            f"{needed} are needed. Record more."
        )
    return least


def _search(
    examiner: Examiner, learner: str, threshold: float | str | None, least: int
) -> list[Trial]:
    """Trials of a learner on all takes: its defaults, and the most promising of its grid."""
    usual = Candidate(learner, {}, threshold)
    coarse = _some_takes(examiner) if learner == "svr" else None
    tried = examiner.run([usual], used=coarse)
    best = tried[0]
    for setting in GRIDS[learner]:
        offered = [one for one in others(best.candidate, setting) if one.neighbors <= least / 2]
        tried += examiner.run(offered, used=coarse)
        best = min(tried, key=Trial.mean)
    if coarse is None:
        return tried
    ranked = sorted(tried[1:], key=Trial.mean)
    return examiner.run([usual, *(trial.candidate for trial in ranked[:FINALISTS])])


def _some_takes(examiner: Examiner) -> list[Mask] | None:
    """For each fold whole takes of about `COARSE` pairs to learn from; None where all are few."""
    takes = examiner.pairs.takes
    if len(takes) <= 1.5 * COARSE:
        return None
    masks = []
    for held in examiner.folds:
        names, sizes = np.unique(takes[~held], return_counts=True)
        enough = max(1, int(np.searchsorted(np.cumsum(sizes), COARSE)) + 1)
        masks.append(np.isin(takes, names[:enough]))
    return masks


def _with_cleaning(
    examiner: Examiner, chosen: Candidate, threshold: float | str | None
) -> list[Trial]:
    """The chosen settings with cleaning where they had none, and without where they had it."""
    asked: list[float | str | None] = [None]
    if threshold is None:
        asked = [one for one in THRESHOLDS if _bears_cleaning(examiner, chosen, one)]
    return examiner.run([Candidate(chosen.learner, chosen.settings, one) for one in asked])


def _bears_cleaning(examiner: Examiner, chosen: Candidate, threshold: float | str) -> bool:
    """Whether enough pairs are left to learn from: more than half, and enough for a decision."""
    try:
        left = examiner.taught(threshold)
    except InvalidInputError:
        return False  # too few to look for conflicts among
    return bool((left > examiner.taught() / 2).all() and left.min() >= chosen.neighbors)


def _learning_curve(examiner: Examiner, chosen: Trial) -> list[tuple[float, Trial]]:
    """Shares of the takes learned from, and the trial of each: halves, each in turn, and all.

    Only all where half of the takes can be too few for a decision.
    """
    halves = []
    for part in range(2):
        used = []
        for held in examiner.folds:
            names = np.unique(examiner.pairs.takes[~held])
            mine = names[part::2] if len(names) > 1 else names
            used.append(np.isin(examiner.pairs.takes, mine))
        one = chosen.candidate
        if examiner.taught(one.threshold, used).min() < max(one.neighbors, 1):
            return [(1.0, chosen)]
        halves += examiner.run([one], used=used)
    both = np.mean([trial.wrong for trial in halves], axis=0)
    return [
        (0.5, Trial(chosen.candidate, both, chosen.takes, chosen.symbols)),
        (1.0, chosen),
    ]


def _baselines(examiner: Examiner, names: Sequence[str]) -> dict[str, Trial]:
    symbols = "voting" in names
    constant = DummyClassifier(strategy="most_frequent") if symbols else DummyRegressor()
    linear = make_pipeline(StandardScaler(), RidgeClassifier() if symbols else Ridge())
    marks = [Candidate(names[0])] * 2
    return dict(zip(("constant", "linear"), examiner.run(marks, [constant, linear]), strict=True))


def _report(
    pairs: Pairs,
    honest: Trial,
    chosen: Trial,
    tried: Sequence[Trial],
    baselines: Mapping[str, Trial],
    uncleaned: Trial,
    cleaned: Sequence[Trial],
    threshold: float | str | None,
    learning: Sequence[tuple[float, Trial]],
    seen: Mapping[str, Trial],
) -> Tuning:
    def lowest(name: str) -> Trial | None:
        found = [trial for trial in tried if trial.candidate.learner == name]
        return min(found, key=lambda trial: trial.held_out.error) if found else None

    smooth, rough = lowest("svr"), lowest("knn")
    recommended: str | None = None
    if smooth and rough and is_better(smooth, rough):
        recommended = "knn"
    elif smooth and rough and is_better(rough, smooth):
        recommended = "svr"
    half, whole = learning[0][1], learning[-1][1]
    before, after = (cleaned, [chosen]) if threshold is not None else ([uncleaned], cleaned)
    pair = (before[0], min(after, key=Trial.mean)) if before and after else None
    own = next(iter(seen.values()), None)
    better = [name for name, trial in seen.items() if own and is_better(own, trial)]
    rows = [Row.of(trial) for trial in tried]
    return Tuning(
        pairs=len(pairs),
        takes=len(np.unique(pairs.takes)),
        symbols=chosen.symbols,
        chosen=chosen.candidate,
        error=honest.held_out.error,
        typical=honest.typical,
        constant=baselines["constant"].held_out.error,
        linear=baselines["linear"].held_out.error,
        beats_constant=is_better(baselines["constant"], honest),
        beats_linear=is_better(baselines["linear"], honest),
        by_take={
            take: {
                "chosen": error,
                **{name: one.held_out.by_take[take] for name, one in baselines.items()},
            }
            for take, error in honest.held_out.by_take.items()
        },
        trials=tuple(rows),
        roughness=None if not (smooth and rough) else _ratio(smooth, rough),
        recommended=recommended,
        cleaning=None if pair is None else (pair[0].held_out.error, pair[1].held_out.error),
        cleaning_helps=pair is not None and is_better(*pair),
        cleaning_harms=pair is not None and is_better(pair[1], pair[0]),
        learning=tuple((share, trial.held_out.error) for share, trial in learning),
        more_would_help=is_better(half, whole),
        perceptions={name: trial.held_out.error for name, trial in seen.items()},
        better_perception=min(better, key=lambda name: seen[name].held_out.error, default=None),
    )


def _ratio(smooth: Trial, rough: Trial) -> float:
    below = rough.held_out.error
    return float(smooth.held_out.error / below) if below > 0.0 else 1.0
