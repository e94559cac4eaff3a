"""The kept takes of a session as a perception of its scene gives them, and how late they answer."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from evastudio.demonstrations.pairs import Pairs, SeenTake, join_pairs, see_take
from evastudio.demonstrations.records import SessionRecord
from evastudio.demonstrations.store import Store
from evastudio.errors import InvalidInputError
from evastudio.learning.delay import Asked, Delay, delay_as_asked
from evastudio.learning.diagnostics import diagnose
from evastudio.learning.finding import Finding
from evastudio.learning.perceived import Perceived
from evastudio.workspace import Workspace
from evastudio.world.loading import find_scene
from evastudio.world.scene import Perception, Scene
from evastudio.world.spaces import Symbols

Mask = NDArray[np.bool_]


@dataclass(frozen=True)
class Seen:
    """The kept takes of a session under one perception."""

    scene: Scene
    perception: Perception
    takes: tuple[SeenTake, ...]

    @property
    def recorded(self) -> int:
        """Decision steps in all of them."""
        return sum(len(take) for take in self.takes)

    def pairs(self, delay_steps: int = 0) -> Pairs:
        """Their pairs, a delay taken out; see `SeenTake.pairs`."""
        return join_pairs([take.pairs(delay_steps) for take in self.takes])

    def perceived(self, delay_steps: int = 0) -> Perceived:
        """The same with the frames that the actions are given in."""
        frames = [take.frames(delay_steps) for take in self.takes]
        return Perceived(self.perception, self.pairs(delay_steps), np.concatenate(frames))

    def delay(self, asked: Asked = "auto") -> Delay:
        """How late their actions are, or as `asked`. Raises InvalidInputError."""
        return delay_as_asked(
            asked, lambda steps: self._counted(self.pairs(steps)), self.scene.dt_s
        )

    def findings(self, pairs: Pairs) -> list[Finding]:
        """What there is to say of `pairs` of these takes; see `diagnose`."""
        return diagnose(self._counted(pairs), self.perception.state, self.scene.dt_s)

    def marks(self, pairs: Pairs, conflicts: Mask) -> dict[int, Mask]:
        """`conflicts` among `pairs` of these takes, by take: one bit for each recorded step.

        What is marked is the action of a step, whatever state it is paired with later.
        """
        marks = {take.take: np.zeros(len(take), dtype=bool) for take in self.takes}
        for take, mask in marks.items():
            rows = pairs.takes == take
            mask[pairs.steps[rows]] = conflicts[rows]
        return marks

    def _counted(self, pairs: Pairs) -> Pairs:
        """`pairs`, symbols as one component each: 1 for the one that was chosen."""
        chosen = self.scene.chosen(self.perception)
        if isinstance(chosen, Symbols):
            ones = np.eye(len(chosen.names))[pairs.actions[:, 0].astype(np.int64)]
            return replace(pairs, actions=ones)
        return pairs


def see_session(
    workspace: Workspace,
    store: Store,
    session: SessionRecord,
    perceptions: Sequence[str | None] = (None,),
) -> list[Seen]:
    """The kept takes of a session under each of `perceptions`.

    Raises NotFoundError for an unknown perception, InvalidInputError where no take is kept.
    """
    kind = find_scene(session.scene, workspace.scene_folders)
    scene = kind()
    names = [scene.perception(name).name for name in perceptions]
    parts: list[list[SeenTake]] = [[] for _ in names]
    takes = [take for take in store.takes(session.id) if take.pairs]
    for take, data in zip(takes, store.load_takes([take.id for take in takes]), strict=True):
        scene = kind(**take.options)
        for part, name in zip(parts, names, strict=True):
            view = scene.perception(name)
            part.append(see_take(view, data.snapshots, data.actions, take.id))
    if not any(parts):
        raise InvalidInputError(
            f"Session {session.name!r} has no pairs: no take is kept. Record a take first."
        )
    return [
        Seen(scene, scene.perception(name), tuple(part))
        for name, part in zip(names, parts, strict=True)
    ]


def perceptions_alike(scene: Scene, perception: str | None) -> list[str]:
    """That perception, and the others under which the same is chosen, by name.

    Raises NotFoundError.
    """
    chosen = scene.perception(perception)
    others = scene.perceptions.items()
    alike = [name for name, other in others if scene.chosen(other) == scene.chosen(chosen)]
    return [chosen.name, *(name for name in alike if name != chosen.name)]


def unmarked(pairs: Pairs, marks: Mapping[int, Mask]) -> Mask:
    """Which of `pairs` no cleaning marked, shape (pairs,); steps it did not see are not marked."""
    keep = np.ones(len(pairs), dtype=bool)
    for take, mask in marks.items():
        rows = np.flatnonzero((pairs.takes == take) & (pairs.steps < len(mask)))
        keep[rows] = ~mask[pairs.steps[rows]]
    return keep
