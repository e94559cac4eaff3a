"""Finding scenes: one Python file each, shipped ones and a user's by the same route.

A scene that was loaded here travels to other processes, on this machine or another, by value: as
the text of its file and its options. They need the same version of this package, and no file.
"""

from __future__ import annotations

import copyreg
import hashlib
import sys
from collections.abc import Iterable, Mapping
from functools import lru_cache
from pathlib import Path
from types import ModuleType
from typing import Any

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
    try:
        source = path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise InvalidInputError(f"The scene file {str(path)!r} cannot be read: {error}.") from None
    return _run(source, path.stem, path)


@lru_cache(maxsize=64)
def _carried(source: str, stem: str) -> type[Scene]:
    """The scene class of a file's text, in a process that may not have the file."""
    return _run(source, stem, Path(f"{stem}.py"))


def _run(source: str, stem: str, path: Path) -> type[Scene]:
    """The scene class that `source` defines, ready to be sent to other processes."""
    if path.suffix != ".py":
        raise InvalidInputError(f"{str(path)!r} is not a Python file; a scene is one .py file.")
    module = ModuleType(_module_name(source, stem))
    module.__file__ = str(path)
    vars(module)["__source__"] = source
    sys.modules[module.__name__] = module
    try:
        exec(compile(source, str(path), "exec"), vars(module))
    except (Exception, SystemExit) as error:  # whatever a user's file may raise while it runs
        del sys.modules[module.__name__]
        raise InvalidInputError(
            f"The scene file {str(path)!r} does not run: {type(error).__name__}: {error}."
        ) from error
    chosen = _declared(module, path)

    def reduced(scene: Scene) -> tuple[Any, ...]:
        return _made_again, (source, stem, dict(scene.values))

    copyreg.pickle(chosen, reduced)
    return chosen


def _made_again(source: str, stem: str, values: Mapping[str, float]) -> Scene:
    """A scene that came from another process, by value: its file's text and its options."""
    return _carried(source, stem)(**values)


def _declared(module: ModuleType, path: Path) -> type[Scene]:
    """The scene class of a module that has run."""
    chosen = getattr(module, "SCENE", None)
    if chosen is None:
        own = [
            value
            for value in vars(module).values()
            if isinstance(value, type)
            and issubclass(value, Scene)
            and value.__module__ == module.__name__
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


def _module_name(source: str, stem: str) -> str:
    """The same in every process, wherever the file lies there: a cluster tells types by name."""
    digest = hashlib.sha256(source.encode()).hexdigest()[:8]
    return f"evastudio_scene_{stem}_{digest}"
