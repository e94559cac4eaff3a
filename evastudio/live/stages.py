"""The stages of a server: opened, found and closed by name."""

from __future__ import annotations

import contextlib
import secrets
import threading
from collections.abc import Mapping
from concurrent.futures import ThreadPoolExecutor

from evastudio.demonstrations.store import Store
from evastudio.errors import BusyError, ConflictError, NotFoundError, StudioError, not_found
from evastudio.live.headless import make_scene
from evastudio.live.live_stage import LiveStage
from evastudio.live.rescue import Rescue
from evastudio.live.tally import Tally, total
from evastudio.workspace import Workspace
from evastudio.world import compiled

MAX_STAGES = 60


class Stages:
    """The stages of a server."""

    def __init__(self, workspace: Workspace, store: Store) -> None:
        self._workspace = workspace
        self._store = store
        self._stages: dict[str, LiveStage] = {}
        self._lock = threading.Lock()
        self._closed = Tally()
        self._ended = False
        self._thinking = ThreadPoolExecutor(max_workers=1, thread_name_prefix="coach")
        """For the coaches of all stages, one after the other."""
        self._rescue = Rescue(store, workspace.unsaved)
        self._rescue.begin()
        self._rescue.wait()

    def open(
        self,
        scene: str,
        options: Mapping[str, float] | None = None,
        session: int | None = None,
        seed: int | None = None,
    ) -> LiveStage:
        """A new stage. Raises BusyError where too many are open, ConflictError at the end."""
        made = make_scene(self._workspace, scene, options)
        with self._lock:
            if self._ended:
                raise ConflictError("The studio is being closed.")
            if len(self._stages) >= MAX_STAGES:
                raise BusyError(
                    f"{MAX_STAGES} stages are open already; close a page that shows one."
                )
            if not compiled.is_loaded():
                threading.Thread(target=compiled.load, name="loading", daemon=True).start()
            name = secrets.token_hex(6)
            stage = LiveStage(name, self._workspace, self._store, made, self._thinking.submit, seed)
            self._stages[name] = stage
        try:
            stage.choose_session(session)
        except StudioError:
            self.close(name)
            raise
        return stage

    def get(self, name: str) -> LiveStage:
        """Raises NotFoundError."""
        with self._lock:
            stage = self._stages.get(name)
        if stage is None:
            raise not_found("stage", name, [])
        return stage

    def all(self) -> list[LiveStage]:
        with self._lock:
            return list(self._stages.values())

    def tally(self) -> Tally:
        """The decisions of all stages, closed ones too."""
        with self._lock:
            return total([self._closed, *(stage.tally for stage in self._stages.values())])

    def close(self, name: str) -> None:
        """Close a stage; its running take is kept."""
        stage = self.get(name)
        with self._lock:
            if self._stages.pop(name, None) is not None:
                self._closed = total([self._closed, stage.tally])
        if not stage.close():
            self._rescue.begin()

    def close_all(self) -> None:
        """Close every stage, all at once: each may have to wait for the store."""
        self._rescue.close()
        with self._lock:
            self._ended = True
            names = list(self._stages)
        try:
            with ThreadPoolExecutor(max_workers=max(1, len(names))) as closing:
                list(closing.map(self._close, names))
        finally:
            self._thinking.shutdown(cancel_futures=True)

    def _close(self, name: str) -> None:
        with contextlib.suppress(NotFoundError):  # somebody was faster
            self.close(name)
