"""A folder of clips, and which of them is played for which activity."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

from evastudio.errors import InvalidInputError, StorageError, StudioError, not_found
from evastudio.motion.bvh import read_bvh
from evastudio.motion.clip import Clip
from evastudio.motion.figures import GAITS, Figures
from evastudio.motion.gait import Gait
from evastudio.motion.glb import Glb
from evastudio.motion.mocap import read_mocap
from evastudio.motion.moment import Activity
from evastudio.motion.movements import movement_of
from evastudio.motion.poses import Poses
from evastudio.motion.retarget import retargeted
from evastudio.motion.steps import gait_of

CHOICES = "clips.json"
"""In the folder itself: activity -> file and clip."""
MOST_BYTES = 64_000_000
ACTIVITIES = {
    activity.name.lower(): activity
    for activity in (
        Activity.STAND,
        Activity.WALK,
        Activity.RUN,
        Activity.STAGGER,
        Activity.FALLEN,
        Activity.GETTING_UP,
    )
}
"""Activities that a clip can be chosen for, by the names they have in the file of choices."""
SINGLE: Mapping[str, Callable[[bytes, str], Clip]] = {".bvh": read_bvh, ".json": read_mocap}
"""Kinds of files that hold one clip, which has the file's own name."""


@dataclass(frozen=True)
class ClipFile:
    """One file of the folder."""

    name: str
    clips: tuple[str, ...]
    """What it holds; nothing where it cannot be read."""
    problem: str | None = None
    """What is wrong with it, for a person, or None."""


@dataclass(frozen=True)
class Choice:
    """A clip for an activity."""

    file: str
    clip: str


@dataclass(frozen=True)
class Library:
    """The folder `motion/` of a workspace; it need not exist."""

    folder: Path

    def files(self) -> list[ClipFile]:
        """Every file that may hold clips, by name, those that cannot be read with the reason."""
        found = []
        for path in sorted(self.folder.glob("*")):
            if path.suffix.lower() not in (*SINGLE, ".glb") or path.name == CHOICES:
                continue
            try:
                found.append(ClipFile(path.name, tuple(self._clips(path.name))))
            except StudioError as error:
                found.append(ClipFile(path.name, (), str(error)))
        return found

    def clip(self, file: str, clip: str) -> Clip:
        """One clip of one file. Raises NotFoundError, InvalidInputError, StorageError."""
        clips = self._clips(file)
        if clip not in clips:
            raise not_found(f"clip in {file!r}", clip, clips)
        return clips[clip]()

    def choices(self) -> dict[Activity, Choice]:
        """What was chosen; activities without a choice move as shipped. Raises StorageError."""
        path = self.folder / CHOICES
        try:
            told = json.loads(path.read_bytes()) if path.exists() else {}
            return {
                ACTIVITIES[name]: Choice(str(one["file"]), str(one["clip"]))
                for name, one in told.items()
            }
        except (OSError, ValueError, KeyError, TypeError, AttributeError, RecursionError) as error:
            raise StorageError(
                f"The choice of clips in {str(path)!r} cannot be read ({type(error).__name__}: "
                f"{error}). Correct it, or delete it to begin with the shipped movements."
            ) from None

    def choose(self, activity: str, file: str, clip: str) -> None:
        """Play that clip for `activity` from now on, if it can be.

        Raises NotFoundError for an unknown activity, file or clip, InvalidInputError for a clip
        that does not fit, StorageError where the choice cannot be written.
        """
        code = self._activity(activity)
        choice = Choice(file, clip)
        _moved(self, code, choice)
        self._write({**self.choices(), code: choice})

    def forget(self, activity: str) -> None:
        """Move as shipped again. Raises NotFoundError for an unknown activity."""
        code = self._activity(activity)
        self._write({one: choice for one, choice in self.choices().items() if one != code})

    def figures(self) -> Figures:
        """Figures that move as was chosen. Raises as `clip` and `choices` do."""
        gaits: dict[Activity, Gait] = {}
        movements: dict[Activity, Poses] = {}
        for activity, choice in self.choices().items():
            moved = _moved(self, activity, choice)
            if isinstance(moved, Gait):
                gaits[activity] = moved
            else:
                movements[activity] = moved
        return Figures(gaits, movements)

    def _activity(self, name: str) -> Activity:
        if name not in ACTIVITIES:
            raise not_found("activity", name, ACTIVITIES)
        return ACTIVITIES[name]

    def _clips(self, file: str) -> Mapping[str, Callable[[], Clip]]:
        """The clips of a file in this very folder, each to be read when it is called."""
        path = self.folder / file
        kind = path.suffix.lower()
        if Path(file).name != file or not path.is_file() or kind not in (*SINGLE, ".glb"):
            known = [one.name for one in self.folder.glob("*") if one.name != CHOICES]
            raise not_found("file of clips", file, known)
        try:
            status = path.stat()
            if status.st_size > MOST_BYTES:
                raise InvalidInputError(
                    f"{file!r} has {status.st_size} bytes; a file of clips may have {MOST_BYTES}."
                )
            return _read(path, status.st_mtime_ns)
        except OSError as error:
            raise StorageError(
                f"{str(path)!r} cannot be read ({error.strerror or error}); check its permissions."
            ) from None

    def _write(self, choices: Mapping[Activity, Choice]) -> None:
        path = self.folder / CHOICES
        told = {code.name.lower(): vars(choice) for code, choice in sorted(choices.items())}
        fresh = path.with_suffix(".new")
        try:
            self.folder.mkdir(parents=True, exist_ok=True)
            fresh.write_text(json.dumps(told, indent=2) + "\n", encoding="utf-8")
            fresh.replace(path)
        except OSError as error:
            raise StorageError(
                f"The choice of clips cannot be written to {str(path)!r} "
                f"({error.strerror or error}); check the folder's permissions."
            ) from None


@lru_cache(maxsize=8)
def _read(path: Path, _changed_at: int) -> Mapping[str, Callable[[], Clip]]:
    """Read a file anew only when it has changed."""
    data = path.read_bytes()
    kind = path.suffix.lower()
    if kind == ".glb":
        glb = Glb(data, path.name)
        return {name: _one_of(glb, name) for name in glb.clip_names}
    clip = SINGLE[kind](data, path.stem)
    return {path.stem: lambda: clip}


def _one_of(glb: Glb, name: str) -> Callable[[], Clip]:
    return lambda: glb.clip(name)


def _moved(library: Library, activity: Activity, choice: Choice) -> Gait | Poses:
    """The chosen clip on the shipped body."""
    clip = library.clip(choice.file, choice.clip)
    poses = retargeted(clip)
    if activity in GAITS:
        return gait_of(poses, clip.rate_hz, clip.name)
    return movement_of(poses, clip.rate_hz, clip.name, repeats=activity == Activity.STAND)
