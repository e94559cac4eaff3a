"""Finding scenes: one Python file each, shipped ones and a user's by the same route."""

from __future__ import annotations

import hashlib
import importlib.util
import sys
from collections.abc import Iterable, Mapping
from functools import lru_cache
from pathlib import Path

from evastudio.errors import InvalidInputError, NotFoundError, not_found
from evastudio.world.scene import Scene

DECLARED = ("name", "title", "version", "dt_s", "render_hz", "outcomes", "successes", "look")
"""What a scene class says of itself before it is made."""


def load_scene_file(path: Path) -> type[Scene]:
    """The scene class of a Python file: its `SCENE`, or else the only `Scene` it defines.

    The file is executed. Raises NotFoundError for a missing file and InvalidInputError for one
    that does not run or holds no scene.
    """
    if not path.is_file():
        raise NotFoundError(f"There is no scene file {str(path)!r}; give the path of a .py file.")
    return _load(path.resolve(), path.stat().st_mtime_ns)


@lru_cache(maxsize=64)
def _load(path: Path, _changed_at: int) -> type[Scene]:
    """Load a scene file anew only when it has changed."""
    module_name = _module_name(path)
    spec = importlib.util.spec_from_file_location(module_name, path)
    if spec is None or spec.loader is None:
        raise InvalidInputError(f"{str(path)!r} is not a Python file; a scene is one .py file.")
    module = importlib.util.module_from_spec(spec)
    sys.modules[module_name] = module
    try:
        spec.loader.exec_module(module)
    except (Exception, SystemExit) as error:  # whatever a user's file may raise while it runs
        del sys.modules[module_name]
        raise InvalidInputError(
            f"The scene file {str(path)!r} does not run: {type(error).__name__}: {error}."
        ) from error
    chosen = getattr(module, "SCENE", None)
    if chosen is None:
        own = [
            value
            for value in vars(module).values()
            if isinstance(value, type)
            and issubclass(value, Scene)
            and value.__module__ == module_name
        ]
        if len(own) != 1:
            raise InvalidInputError(
                f"The scene file {str(path)!r} defines {len(own)} scenes; it must define one "
                "subclass of evastudio.world.scene.Scene, or name it: SCENE = ..."
            )
        chosen = own[0]
    if not (isinstance(chosen, type) and issubclass(chosen, Scene)):
        raise InvalidInputError(
            f"SCENE in {str(path)!r} is {chosen!r}; it must be a subclass of Scene."
        )
    missing = [name for name in DECLARED if not hasattr(chosen, name)]
    missing += sorted(chosen.__abstractmethods__)
    if missing:
        raise InvalidInputError(
            f"The scene in {str(path)!r} lacks {', '.join(missing)}; every scene needs them."
        )
    return chosen


def find_scenes(folders: Iterable[Path]) -> Mapping[str, type[Scene]]:
    """Every scene in `folders` by name; where two share a name, the first folder's wins.

    A file that does not load is left out here; `evastudio check FILE` says what is wrong.
    """
    scenes: dict[str, type[Scene]] = {}
    for folder in folders:
        for path in sorted(folder.glob("*.py")):
            try:
                scene = load_scene_file(path)
            except InvalidInputError:
                continue
            scenes.setdefault(scene.name, scene)
    return scenes


def find_scene(name: str, folders: Iterable[Path]) -> type[Scene]:
    """The scene class called `name`. Raises NotFoundError, with the names there are."""
    places = tuple(folders)
    scenes = find_scenes(places)
    if name not in scenes:
        missing = not_found("scene", name, scenes)
        broken = broken_scenes(places)
        if not broken:
            raise missing
        told = " ".join(broken.values())
        raise NotFoundError(f"{missing} Some scene files could not be used: {told}")
    return scenes[name]


def broken_scenes(folders: Iterable[Path]) -> Mapping[Path, str]:
    """Scene files in `folders` that cannot be used, and why."""
    broken: dict[Path, str] = {}
    for folder in folders:
        for path in sorted(folder.glob("*.py")):
            try:
                load_scene_file(path)
            except InvalidInputError as error:
                broken[path] = str(error)
    return broken


def _module_name(path: Path) -> str:
    digest = hashlib.sha256(str(path.resolve()).encode()).hexdigest()[:8]
    return f"evastudio_scene_{path.stem}_{digest}"
