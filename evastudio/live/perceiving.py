"""The kept takes of a session, as perceptions of its scene give them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from evastudio.demonstrations.pairs import Pairs, join_pairs, perceive_take
from evastudio.demonstrations.records import SessionRecord
from evastudio.demonstrations.store import Store
from evastudio.errors import InvalidInputError
from evastudio.learning.perceived import Perceived
from evastudio.workspace import Workspace
from evastudio.world.cast import of_lead
from evastudio.world.loading import find_scene
from evastudio.world.scene import Scene
from evastudio.world.snapshot import AnyArray


def perceive_session(
    workspace: Workspace,
    store: Store,
    session: SessionRecord,
    perceptions: Sequence[str | None] = (None,),
) -> tuple[Scene, list[Perceived]]:
    """The scene of a session, and the pairs of its kept takes under each of `perceptions`.

    Raises NotFoundError for an unknown perception, InvalidInputError where no take is kept.
    """
    kind = find_scene(session.scene, workspace.scene_folders)
    scene = kind()
    names = [scene.perception(name).name for name in perceptions]
    parts: list[list[Pairs]] = [[] for _ in names]
    frames: list[list[AnyArray]] = [[] for _ in names]
    for take in store.takes(session.id):
        if take.pairs:
            scene = kind(**take.options)
            data = store.load_take(take.id)
            for number, name in enumerate(names):
                view = scene.perception(name)
                parts[number].append(perceive_take(view, data.snapshots, data.actions, take.id))
                frame = view.perceive(data.snapshots).frame
                frames[number].append(of_lead(data.snapshots, frame))
    if not any(parts):
        raise InvalidInputError(
            f"Session {session.name!r} has no pairs: no take is kept. Record a take first."
        )
    return scene, [
        Perceived(scene.perception(name), join_pairs(pairs), np.concatenate(frame))
        for name, pairs, frame in zip(names, parts, frames, strict=True)
    ]


def session_pairs(
    workspace: Workspace, store: Store, session: SessionRecord, perception: str | None
) -> tuple[Scene, Pairs]:
    """The pairs of a session's kept takes, as `perception` gives them, and their scene."""
    scene, (view,) = perceive_session(workspace, store, session, [perception])
    return scene, view.pairs
