"""From pairs to a policy: cleaning, learners, policy files."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from evastudio.learning.conflicts import ConflictEliminator
    from evastudio.learning.knn import KNNPolicy
    from evastudio.learning.local_linear import LocalLinearPolicy
    from evastudio.learning.mlp import MLPPolicy
    from evastudio.learning.policy_files import load_policy, save_policy
    from evastudio.learning.sampled import SampledKNNPolicy
    from evastudio.learning.svr import SVRPolicy
    from evastudio.learning.voting import VotingKNNPolicy

_FROM = {
    "ConflictEliminator": "conflicts",
    "KNNPolicy": "knn",
    "LocalLinearPolicy": "local_linear",
    "MLPPolicy": "mlp",
    "SVRPolicy": "svr",
    "SampledKNNPolicy": "sampled",
    "VotingKNNPolicy": "voting",
    "load_policy": "policy_files",
    "save_policy": "policy_files",
}

__all__ = [
    "ConflictEliminator",
    "KNNPolicy",
    "LocalLinearPolicy",
    "MLPPolicy",
    "SVRPolicy",
    "SampledKNNPolicy",
    "VotingKNNPolicy",
    "load_policy",
    "save_policy",
]


def __getattr__(name: str) -> Any:
    """Import on first use: learners bring scikit-learn with them."""
    if name not in _FROM:
        raise AttributeError(f"module 'evastudio.learning' has no attribute {name!r}")
    return getattr(import_module(f"evastudio.learning.{_FROM[name]}"), name)
