"""A policy: a fitted learner, and everything needed to know what it is and where it came from."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from evastudio.demonstrations.pairs import Pairs
from evastudio.learning.knn import KNNPolicy
from evastudio.learning.svr import SVRPolicy
from evastudio.world.spaces import Array, Box

Learner = KNNPolicy | SVRPolicy

LEARNERS: Mapping[str, type[KNNPolicy] | type[SVRPolicy]] = {"svr": SVRPolicy, "knn": KNNPolicy}


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
    action: Box
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
    created: str = ""
    """When, ISO 8601; given by whoever fitted it."""
    extra: Mapping[str, Any] = field(default_factory=dict)
    """Anything else worth keeping, JSON-able."""

    @property
    def learner_name(self) -> str:
        """The name users know the learner by: svr, knn."""
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

    def act_states(self, states: Array) -> Array:
        """Actions (rows, m) in the character's own frame for states (rows, n).

        Raises InvalidInputError for another width, NaN or infinities.
        """
        return self.learner.decide(self.state.check(states, "states"))

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
