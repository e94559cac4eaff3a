"""A folder of clips, and which of them is played for which activity."""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

from evastudio.errors import InvalidInputError, StorageError, StudioError, not_found
from evastudio.motion.bvh import read_bvh
from evastudio.motion.clip import Clip
from evastudio.motion.figures import GAITS, Figures, figures
from evastudio.motion.gait import Gait
from evastudio.motion.glb import Glb
from evastudio.motion.mocap import read_mocap
from evastudio.motion.moment import Activity
from evastudio.motion.movements import movement_of
from evastudio.motion.poses import Poses
from evastudio.motion.retarget import retargeted
from evastudio.motion.steps import gait_of
from evastudio.writing import write_whole

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
KINDS = (".glb", *SINGLE)
NAME = re.compile(r"[\w][\w .-]{0,99}")
"""Of a file that is added."""
Source = tuple[Activity, Path, int, str]
"""An activity, a file, when that was changed, and the clip in it."""


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
            known = path.suffix.lower() in KINDS and path.name != CHOICES
            if not known or not path.name.isprintable():
                continue
            try:
                found.append(ClipFile(path.name, self.clips(path.name)))
            except StudioError as error:
                found.append(ClipFile(path.name, (), str(error)))
        return found

    def clips(self, file: str) -> tuple[str, ...]:
        """What one file holds. Raises NotFoundError, InvalidInputError, StorageError."""
        return tuple(_read(*self._found(file)))

    def clip(self, file: str, clip: str) -> Clip:
        """One clip of one file. Raises NotFoundError, InvalidInputError, StorageError."""
        clips = _read(*self._found(file))
        if clip not in clips:
            raise not_found("clip", clip, clips, f"in {file!r}")
        return clips[clip]()

    def choices(self) -> dict[Activity, Choice]:
        """What was chosen; activities without a choice move as shipped. Raises StorageError."""
        path = self.folder / CHOICES
        try:
            told = json.loads(path.read_bytes()) if path.exists() else {}
            json.dumps(told, ensure_ascii=False).encode()  # half a letter cannot be told to a page
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
        _moved(*self._source(code, choice))
        self._write({**self.choices(), code: choice})

    def forget(self, activity: str) -> None:
        """Move as shipped again. Raises NotFoundError for an unknown activity."""
        code = self._activity(activity)
        self._write({one: choice for one, choice in self.choices().items() if one != code})

    def add(self, name: str, data: bytes) -> ClipFile:
        """Keep `data` as the file of that name, in place of one that has it already.

        Raises InvalidInputError, and keeps nothing, for a name that is none for a file of clips,
        and for clips that cannot be read; StorageError where it cannot be written.
        """
        kind = Path(name).suffix.lower()
        if not NAME.fullmatch(name) or kind not in KINDS or name == CHOICES:
            raise InvalidInputError(
                f"{name[:120]!r} is no name for a file of clips; it may have letters, digits, "
                f"spaces, '.', '-' and '_', and ends in {', '.join(KINDS)}."
            )
        clips = tuple(_clips_in(data, name))
        write_whole(self.folder / name, data)
        return ClipFile(name, clips)

    def figures(self) -> Figures:
        """Figures that move as was chosen. Raises as `clip` and `choices` do."""
        return _figures(tuple(self._source(*chosen) for chosen in self.choices().items()))

    def playable(self) -> tuple[Figures, dict[Activity, str]]:
        """Figures that move as was chosen, where that can be played, and as shipped elsewhere.

        With it comes, for each activity whose clip cannot be played any more, the reason. Raises
        StorageError where the choices cannot be read.
        """
        sources, problems = [], {}
        for activity, choice in self.choices().items():
            try:
                source = self._source(activity, choice)
                _moved(*source)
            except StudioError as error:
                problems[activity] = str(error)
            else:
                sources.append(source)
        return _figures(tuple(sources)), problems

    def _activity(self, name: str) -> Activity:
        if name not in ACTIVITIES:
            raise not_found("activity", name, ACTIVITIES)
        return ACTIVITIES[name]

    def _source(self, activity: Activity, choice: Choice) -> Source:
        return (activity, *self._found(choice.file), choice.clip)

    def _found(self, file: str) -> tuple[Path, int]:
        """Where a file of this very folder is, and when it was changed."""
        path = self.folder / file
        try:
            there = Path(file).name == file and path.is_file() and path.suffix.lower() in KINDS
            status = path.stat() if there else None
        except (OSError, ValueError):  # the latter for a name that no file can have
            status = None
        if status is None:
            known = [one.name for one in self.folder.glob("*") if one.name != CHOICES]
            raise not_found("file of clips", file, known)
        if status.st_size > MOST_BYTES:
            raise InvalidInputError(
                f"{file!r} has {status.st_size} bytes; a file of clips may have {MOST_BYTES}."
            )
        return path, status.st_mtime_ns

    def _write(self, choices: Mapping[Activity, Choice]) -> None:
        told = {code.name.lower(): vars(choice) for code, choice in sorted(choices.items())}
        write_whole(self.folder / CHOICES, (json.dumps(told, indent=2) + "\n").encode())


@lru_cache(maxsize=8)
def _read(path: Path, _changed_at: int) -> Mapping[str, Callable[[], Clip]]:
    """Read a file anew only when it has changed."""
    try:
        data = path.read_bytes()
    except OSError as error:
        raise StorageError(
            f"{str(path)!r} cannot be read ({error.strerror or error}); check its permissions."
        ) from None
    return _clips_in(data, path.name)


def _clips_in(data: bytes, name: str) -> Mapping[str, Callable[[], Clip]]:
    """The clips of a file by name, each to be read when it is called."""
    path = Path(name)
    kind = path.suffix.lower()
    if kind == ".glb":
        glb = Glb(data, name)
        return {clip: _one_of(glb, clip) for clip in glb.clip_names}
    clip = SINGLE[kind](data, path.stem)
    return {path.stem: lambda: clip}


def _one_of(glb: Glb, name: str) -> Callable[[], Clip]:
    return lambda: glb.clip(name)


@lru_cache(maxsize=16)
def _moved(activity: Activity, path: Path, changed_at: int, name: str) -> Gait | Poses:
    """The clip of that name on the shipped body."""
    clips = _read(path, changed_at)
    if name not in clips:
        raise not_found("clip", name, clips, f"in {path.name!r}")
    clip = clips[name]()
    poses = retargeted(clip)
    if activity in GAITS:
        return gait_of(poses, clip.rate_hz, clip.name)
    return movement_of(poses, clip.rate_hz, clip.name, repeats=activity == Activity.STAND)


@lru_cache(maxsize=4)
def _figures(sources: tuple[Source, ...]) -> Figures:
    """One for each distinct choice, so that opening a stage costs nothing."""
    if not sources:
        return figures()
    gaits: dict[Activity, Gait] = {}
    movements: dict[Activity, Poses] = {}
    for source in sources:
        moved = _moved(*source)
        if isinstance(moved, Gait):
            gaits[source[0]] = moved
        else:
            movements[source[0]] = moved
    return Figures(gaits, movements)
