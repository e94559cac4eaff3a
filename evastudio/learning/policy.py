"""A policy: a fitted learner, and everything needed to know what it is and where it came from."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from evastudio.demonstrations.pairs import Pairs
from evastudio.errors import InvalidInputError, not_found
from evastudio.learning.checking import bearable
from evastudio.learning.knn import KNNPolicy
from evastudio.learning.learner import Indices, Learner, Reasons
from evastudio.learning.local_linear import LocalLinearPolicy
from evastudio.learning.mlp import MLPPolicy
from evastudio.learning.quantized import QuantizedKNNPolicy, QuantizedSVRPolicy
from evastudio.learning.sampled import SampledKNNPolicy
from evastudio.learning.svr import SVRPolicy
from evastudio.learning.voting import SampledVotingPolicy, VotingKNNPolicy
from evastudio.world.spaces import Array, Box, Space

LEARNERS: Mapping[str, type[Learner]] = {
    "svr": SVRPolicy,
    "knn": KNNPolicy,
    "local-linear": LocalLinearPolicy,
    "sampled": SampledKNNPolicy,
    "mlp": MLPPolicy,
    "voting": VotingKNNPolicy,
    "sampled-voting": SampledVotingPolicy,
    "quantized-svr": QuantizedSVRPolicy,
    "quantized-knn": QuantizedKNNPolicy,
}
"""By the name users know them by; the first that fits a scene's actions is its default."""


def find_learner(name: str | None, action: Space) -> str:
    """The learner of that name, or the default for an `action` of this kind.

    Raises NotFoundError for an unknown name, InvalidInputError for one that learns another kind.
    """
    fitting = [known for known, kind in LEARNERS.items() if isinstance(action, kind.acts_in)]
    if name is None:
        return fitting[0]
    if name not in LEARNERS:
        raise not_found("learner", name, LEARNERS)
    if name not in fitting:
        what = "numbers" if isinstance(action, Box) else "one of a set of symbols"
        raise InvalidInputError(
            f"Learner {name!r} cannot learn this character's action, which is {what}; choose "
            f"{' or '.join(fitting)}."
        )
    return name


@dataclass(frozen=True)
class Policy:
    """A function from state to action, fitted to pairs of one scene under one perception."""

    learner: Learner
    """Fitted."""
    scene: Mapping[str, Any]
    """Identity of the scene it was shown in: name, version, options."""
    perception: str
    """Name of the perception its states come from."""
    state: Box
    """The state it expects, field by field."""
    action: Space
    """The action it gives, field by field, before the perception turns it to the world's frame."""
    pairs: int
    """How many pairs it was fitted to."""
    fingerprint: str
    """Of those pairs: where the session's pairs now have another, the policy is stale."""
    session: int | str | None = None
    """The session its takes belong to."""
    takes: tuple[int, ...] = ()
    """Identifiers of the takes its pairs came from."""
    cleaning: Mapping[str, Any] | None = None
    """Report of the conflict elimination before fitting; None where there was none."""
    evaluation: Mapping[str, Any] | None = None
    """Report of an evaluation; None where there was none."""
    made_by: str = ""
    """The command that makes it again."""
    moments: Indices | None = None
    """Take and decision step of each pair that the learner keeps, shape (kept, 2): what `pairs`
    of its reasons lead to. None in files that do not have it."""
    created: str = ""
    """When, ISO 8601; given by whoever fitted it."""
    extra: Mapping[str, Any] = field(default_factory=dict)
    """Anything else worth keeping, JSON-able."""

    @property
    def learner_name(self) -> str:
        """The name users know the learner by, as in `LEARNERS`."""
        return next(name for name, kind in LEARNERS.items() if type(self.learner) is kind)

    @property
    def settings(self) -> dict[str, Any]:
        """The learner's hyperparameters."""
        return dict(self.learner.get_params())

    @property
    def scene_name(self) -> str:
        return str(self.scene["name"])

    @property
    def scene_version(self) -> int:
        return int(self.scene["version"])

    def act_states(self, states: Array, rng: np.random.Generator | None = None) -> Array:
        """Actions (rows, m) in the character's own frame for states (rows, n).

        A learner that draws takes its luck from `rng`; without it, it gives what was shown most
        often. Raises InvalidInputError for another width, NaN, infinities or numbers beyond 1e30.
        """
        good = bearable(self.state.check(states, "states"), "states")
        if rng is None or not self.learner.draws:
            return self.learner.decide(good)
        return self.learner.decide(good, rng.random(len(good)))

    def explain(self, states: Array) -> Reasons:
        """Why it decides as it does for states (rows, n); `moments` tells when that was shown.

        Raises InvalidInputError for another width, NaN or infinities.
        """
        return self.learner.explain(self.state.check(states, "states"))

    def without(self, pairs: Indices) -> Policy:
        """This policy once its learner has forgotten the kept `pairs` (any,), which it has then.

        The learner is changed in place: a policy must not be used any more once another was made
        from it. Raises InvalidInputError where too few pairs would be left, or it keeps none.
        """
        self.learner.remove_pairs(pairs)
        moments = None if self.moments is None else np.delete(self.moments, pairs, axis=0)
        return replace(self, pairs=self.pairs - len(np.unique(pairs)), moments=moments)

    def describe(self) -> dict[str, Any]:
        """All but the numbers of the learner, as JSON holds it."""
        return {
            "scene": dict(self.scene),
            "perception": self.perception,
            "learner": self.learner_name,
            "settings": self.settings,
            "session": self.session,
            "takes": list(self.takes),
            "pairs": self.pairs,
            "fingerprint": self.fingerprint,
            "cleaning": None if self.cleaning is None else dict(self.cleaning),
            "evaluation": None if self.evaluation is None else dict(self.evaluation),
            "made_by": self.made_by,
            "created": self.created,
            "extra": dict(self.extra),
        }


def fingerprint(pairs: Pairs) -> str:
    """SHA-256 of states, actions, takes and steps, hexadecimal: equal for equal pairs only."""
    digest = hashlib.sha256()
    for array in (pairs.states, pairs.actions):
        digest.update(repr(array.shape).encode())
        digest.update(np.ascontiguousarray(array, dtype="<f8").tobytes())
    for numbers in (pairs.takes, pairs.steps):
        digest.update(np.ascontiguousarray(numbers, dtype="<i8").tobytes())
    return digest.hexdigest()
