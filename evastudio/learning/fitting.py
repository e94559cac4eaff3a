"""Fitting: from pairs to a policy, with the settings that served best as defaults."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from evastudio.demonstrations.pairs import Pairs
from evastudio.errors import InvalidInputError, not_found
from evastudio.learning.cleaning import Cleaning, Progress, silent
from evastudio.learning.compiled import ensure_compiled
from evastudio.learning.policy import LEARNERS, Policy, find_learner, fingerprint
from evastudio.world.compiled import is_compiled
from evastudio.world.scene import Perception, Scene


def fit_policy(
    pairs: Pairs,
    scene: Scene,
    perception: str | Perception | None = None,
    learner: str | None = None,
    settings: Mapping[str, Any] | None = None,
    *,
    session: int | str | None = None,
    takes: Sequence[int] | None = None,
    cleaning: Cleaning | None = None,
    made_by: str = "",
    created: str = "",
    progress: Progress = silent,
) -> Policy:
    """A policy fitted to `pairs`, which were perceived through `perception` of `scene`.

    Where a `cleaning` of these pairs is given, its conflicts are left out first. `settings`
    replace some of the learner's defaults. `takes` are those of the pairs unless told otherwise.
    Without a `learner`, actions of real numbers are learned by an SVR and symbols by votes.
    Raises NotFoundError for an unknown perception, learner or setting, InvalidInputError for
    a learner, pairs or settings that cannot be used.
    """
    view = scene.perception(perception)
    chosen = scene.chosen(view)
    learner = find_learner(learner, chosen)
    fitted = LEARNERS[learner]()
    for name, value in (settings or {}).items():
        if name not in fitted.get_params():
            raise not_found("setting", name, fitted.get_params(), f"of learner {learner!r}")
        fitted.set_params(**{name: value})
    if cleaning is not None:
        pairs = cleaning.apply(pairs)
    if len(pairs) == 0:
        raise InvalidInputError(
            "There are no pairs to learn from. Record a take first, or clean less strictly."
        )
    view.state.check(pairs.states, "states of the pairs")
    chosen.check(pairs.actions, "actions of the pairs")
    fitted.check_settings()
    if not is_compiled():
        progress(0.0, "Getting ready, once on this machine: half a minute")
        ensure_compiled()
    progress(0.0, f"Fitting {len(pairs)} pairs")
    fitted.learn(
        pairs.states,
        pairs.actions,
        chosen,
        lambda share: progress(share, "Fitting the action"),
    )
    progress(1.0, "Fitted")
    if takes is None:
        takes = [int(take) for take in np.unique(pairs.takes)]
    return Policy(
        learner=fitted,
        scene=scene.identity(),
        perception=view.name,
        state=view.state,
        action=chosen,
        pairs=len(pairs),
        fingerprint=fingerprint(pairs),
        session=session,
        takes=tuple(takes),
        cleaning=None if cleaning is None else cleaning.report(),
        moments=np.stack([pairs.takes, pairs.steps], axis=1)[fitted.kept],
        made_by=made_by,
        created=created,
    )
