"""How somebody moved in the takes of a session, for telling how alike a pilot moves."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from evastudio.demonstrations.store import Store
from evastudio.errors import ConflictError, InvalidInputError
from evastudio.evaluation.evaluate import Shown
from evastudio.evaluation.flight import Flight, path_features
from evastudio.workspace import Workspace
from evastudio.world.loading import find_scene
from evastudio.world.scene import Scene


def shown_in(
    workspace: Workspace, session: int | str, scene: Scene, takes: Sequence[int] | None = None
) -> tuple[Shown, dict[str, Any]]:
    """What the kept takes of a session show, or those that `takes` lists; and which they are.

    Worlds of other options are taken as they are. Raises NotFoundError, ConflictError where the
    session is of another scene or an older version of it, InvalidInputError where nothing is kept.
    """
    with Store(workspace.ready().store_url) as store:
        record = store.session(session)
        if record.scene != scene.name:
            raise ConflictError(
                f"Session {record.name!r} is of scene {record.scene!r}, and this is "
                f"{scene.name!r}. Name a session of the same scene."
            )
        kind = find_scene(record.scene, workspace.scene_folders)
        known = store.takes(record.id, trashed=None)
        if takes is None:
            takes = [take.id for take in known if take.pairs and not take.trashed]
        features = []
        chosen = [take for take in known if take.id in takes]
        contents = store.load_takes([take.id for take in chosen])
        for take in chosen:
            if take.scene_version != scene.version:
                raise ConflictError(
                    f"Take {take.number} of session {record.name!r} was made in version "
                    f"{take.scene_version} of the scene, which is now version {scene.version}."
                )
            place, data = kind(**take.options), next(contents)
            clear = place.clearance(data.snapshots)
            features.append(path_features(place, Flight(data.snapshots, data.actions, clear)))
    if not features:
        raise InvalidInputError(
            f"Session {record.name!r} has no takes to be like: none is kept. Record one first."
        )
    return Shown(f"the takes of “{record.name}”", np.concatenate(features)), {
        "id": record.id,
        "takes": list(takes),
    }
