"""Reviewing the takes of a session: their thumbnails, and which of them look suspicious."""

from __future__ import annotations

import threading
from collections import OrderedDict

from evastudio.demonstrations.records import TakeRecord
from evastudio.demonstrations.store import Store
from evastudio.demonstrations.suspicion import Figures, Remark, figures_of, suspicions
from evastudio.errors import StorageError
from evastudio.live.headless import make_scene
from evastudio.live.thumbnail import thumbnail
from evastudio.workspace import Workspace

KEPT = 20_000
"""Takes whose figures are kept."""
COMPARED = 500
"""So many of the newest takes of a session are looked at."""


class Reviewing:
    """What a studio tells of takes. Safe to use from several threads."""

    def __init__(self, workspace: Workspace, store: Store) -> None:
        self._workspace = workspace
        self._store = store
        self._figures: OrderedDict[tuple[int, int], Figures] = OrderedDict()
        self._lock = threading.Lock()

    def thumbnail(self, record: TakeRecord) -> bytes:
        """See `thumbnail`. Raises NotFoundError where its scene is gone, or it has no pairs."""
        session = self._store.session(record.session)
        scene = make_scene(self._workspace, session.scene, record.options)
        return thumbnail(scene, self._store.load_take(record.id), record.outcome)

    def remarks(self, session: int) -> dict[int, list[Remark]]:
        """What is suspicious about the newest takes of a session, by take.

        Each take is read once; a take that is longer than it was is another. Raises NotFoundError.
        """
        scene_name = self._store.session(session).scene
        scene = make_scene(self._workspace, scene_name)
        takes = self._store.takes(session, None, newest=True, limit=COMPARED)
        takes = [take for take in takes if take.pairs]
        with self._lock:
            missing = [take for take in takes if (take.id, take.pairs) not in self._figures]
        for take in missing:
            try:
                data = self._store.load_take(take.id)
            except StorageError:  # damaged: told where it is read
                continue
            figures = figures_of(scene, data)
            with self._lock:
                self._figures[take.id, take.pairs] = figures
                while len(self._figures) > KEPT:
                    self._figures.popitem(last=False)
        with self._lock:
            known = {
                take.id: self._figures[take.id, take.pairs]
                for take in takes
                if (take.id, take.pairs) in self._figures
            }
        return suspicions(scene.successes, takes, known)
