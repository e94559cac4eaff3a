"""Who learns from the recordings, and how its settings are found inside what it learns from."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from sklearn.compose import TransformedTargetRegressor
from sklearn.dummy import DummyRegressor
from sklearn.linear_model import Ridge
from sklearn.neural_network import MLPRegressor
from sklearn.pipeline import make_pipeline
from sklearn.preprocessing import StandardScaler

from evastudio.demonstrations.pairs import Pairs
from evastudio.learning.holdout import mistakes, take_folds
from evastudio.learning.knn import KNNPolicy
from evastudio.learning.local_linear import LocalLinearPolicy
from evastudio.learning.sampled import SampledKNNPolicy
from evastudio.learning.svr import SVRPolicy

TUNED_ON = 2500
"""Pairs that SVR and the network are tuned on; neighbours are tuned on all."""
HIDDEN = (64, 64)


@dataclass(frozen=True)
class Contender:
    """A learner and the settings it may choose from."""

    name: str
    make: Callable[..., Any]
    grid: tuple[Mapping[str, Any], ...] = ({},)
    most: int = 1_000_000
    """Pairs it is fitted to at most, drawn at random where there are more."""
    ours: bool = True


def network(alpha: float) -> Any:
    """scikit-learn's MLP, inputs and outputs standardised, stopped early."""
    mlp = MLPRegressor(
        hidden_layer_sizes=HIDDEN,
        alpha=alpha,
        early_stopping=True,
        n_iter_no_change=8,
        max_iter=40,
        random_state=0,
    )
    return TransformedTargetRegressor(
        make_pipeline(StandardScaler(), mlp), transformer=StandardScaler()
    )


def linear(alpha: float) -> Any:
    """Ridge regression on standardised states."""
    return make_pipeline(StandardScaler(), Ridge(alpha))


CONTENDERS = (
    Contender("constant", DummyRegressor, ours=False),
    Contender("linear (ridge)", linear, ({"alpha": 1.0}, {"alpha": 100.0}), ours=False),
    Contender("MLP", network, ({"alpha": 1e-3}, {"alpha": 1.0}), ours=False),
    Contender(
        "k-NN",
        KNNPolicy,
        tuple({"k": k, "weights": "distance"} for k in (3, 7, 15, 30, 60, 120)),
    ),
    Contender(
        "SVR",
        SVRPolicy,
        tuple(
            {"C": C, "gamma": gamma, "epsilon": 0.2}
            for gamma in (0.01, 0.05, 0.2, 0.8)
            for C in (1.0, 10.0)
        ),
        most=5000,
    ),
    Contender(
        "local linear",
        LocalLinearPolicy,
        tuple({"k": k} for k in (40, 120, 300)),
    ),
    Contender("sampled k-NN", SampledKNNPolicy, tuple({"k": k} for k in (7, 15, 30))),
)


def drawn(pairs: Pairs, most: int, rng: np.random.Generator) -> NDArray[np.bool_]:
    """Which `most` of the pairs to use, all of them where there are no more; shape (pairs,)."""
    kept = np.zeros(len(pairs), dtype=bool)
    kept[rng.permutation(len(pairs))[:most]] = True
    return kept


def fitted(
    contender: Contender, pairs: Pairs, groups: NDArray[np.int64], rng: np.random.Generator
) -> tuple[Any, Mapping[str, Any]]:
    """The contender fitted to `pairs` and the settings that did best on groups held out of them.

    A quarter of the groups is held out while settings are chosen; then all pairs are fitted.
    """
    limit = len(pairs) if contender.most >= len(pairs) else contender.most
    best = contender.grid[0]
    if len(contender.grid) > 1:
        held = take_folds(groups, 4)[0]
        narrow = limit < len(pairs) or not contender.ours
        used = ~held & drawn(pairs, TUNED_ON if narrow else len(pairs), rng)
        tried = []
        for settings in contender.grid:
            if settings.get("k", 0) > int(used.sum()):
                continue
            learner = contender.make(**settings)
            wrong = mistakes(learner, pairs.states, pairs.actions, held, used)
            tried.append((float(wrong.mean()), len(tried), settings))
        best = min(tried)[2]
    kept = pairs.keep(drawn(pairs, limit, rng))
    return contender.make(**best).fit(kept.states, kept.actions), best
