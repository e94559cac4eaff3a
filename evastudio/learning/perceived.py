"""The same takes under several perceptions, judged where they can be compared: in the world."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import joblib
import numpy as np
from sklearn.base import is_classifier

from evastudio.demonstrations.pairs import Pairs
from evastudio.learning.candidates import Candidate
from evastudio.learning.holdout import answers, judged
from evastudio.learning.scaling import Scaling
from evastudio.learning.trials import Examiner, Trial
from evastudio.world.scene import Perception
from evastudio.world.snapshot import AnyArray
from evastudio.world.spaces import Array


@dataclass(frozen=True)
class Perceived:
    """Some takes as one perception gives them."""

    perception: Perception
    pairs: Pairs
    frame: AnyArray
    """In which its actions are given, shape (pairs, ...); see `Percept.frame`."""

    def in_world(self, actions: Array) -> Array:
        """`actions` (pairs, m) of its own frame, in the world's."""
        return self.perception.to_world(self.frame, actions)


def compare_perceptions(
    views: Sequence[Perceived], learner: Any, examiner: Examiner
) -> dict[str, Trial]:
    """Trials of `learner` under each of `views`, on the folds of `examiner`.

    Each perception turns actions into a frame of its own, where some look easier than others; so
    decisions are turned back, and mistakes are those in the world. Views of other moments than the
    first, where a perception is not about all of a take, cannot be compared. Nothing where there is
    but one.
    """
    views = [view for view in views if _of_same_moments(view.pairs, views[0].pairs)]
    if len(views) < 2:
        return {}
    tasks = []  # of arrays alone: where a perception comes from a scene's file, no worker has it
    for view in views:
        actions = view.pairs.actions[:, 0] if is_classifier(learner) else view.pairs.actions
        tasks += [(learner, view.pairs.states, actions, held) for held in examiner.folds]
    run = joblib.Parallel(n_jobs=examiner.n_jobs, prefer="threads", return_as="generator")
    parts = run(joblib.delayed(answers)(*task) for task in tasks)
    given = [np.empty_like(view.pairs.actions) for view in views]
    for number, part in enumerate(parts):
        row, fold = divmod(number, len(examiner.folds))
        held = examiner.folds[fold]
        given[row][held] = part.reshape(-1, given[row].shape[1])
        examiner.progress((number + 1) / len(tasks), "Trying other perceptions")
    trials = {}
    for view, answered in zip(views, given, strict=True):
        wanted = view.in_world(view.pairs.actions)
        spread = None if is_classifier(learner) else Scaling.of(wanted).scale
        wrong = judged(view.in_world(answered), wanted, spread)
        name = view.perception.name
        trials[name] = Trial(Candidate(name), wrong, view.pairs.takes, spread is None)
    return trials


def _of_same_moments(one: Pairs, other: Pairs) -> bool:
    return np.array_equal(one.takes, other.takes) and np.array_equal(one.steps, other.steps)
