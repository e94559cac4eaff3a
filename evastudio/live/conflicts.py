"""The conflicts of a session as they were looked for last: at any threshold, in a moment."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass, fields
from functools import cached_property, lru_cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from evastudio.demonstrations.packing import pack, unpack
from evastudio.demonstrations.pairs import Pairs
from evastudio.demonstrations.records import SessionRecord, Verdict, Verdicts
from evastudio.errors import InvalidInputError, NotFoundError, StorageError
from evastudio.learning.cleaning import Cleaning
from evastudio.learning.conflicts import usual_actions
from evastudio.workspace import Workspace
from evastudio.world.spaces import Array
from evastudio.writing import write_whole

Mask = NDArray[np.bool_]
Rows = NDArray[np.int64]

_MOST = 2**31
READ = 4
"""Sessions whose conflicts are kept in memory."""


@dataclass(frozen=True)
class About:
    """What was looked at, and how."""

    store: str
    """Identity of the store that holds the session."""
    session: int
    seen: Mapping[int, int]
    """Pairs of each take that was kept then."""
    perception: str
    n_neighbors: int
    delay_s: float
    delay_steps: int
    span: tuple[float, ...]
    """The range of each component of the action; none for symbols."""
    names: tuple[str, ...]
    """Those components by name, or the symbols."""


@dataclass(frozen=True)
class Conflicts:
    """What cleaning has to say of every pair of a session."""

    about: About
    takes: Rows
    """The take of each pair, (pairs,)."""
    steps: Rows
    """The step of its action there, (pairs,)."""
    actions: Array
    """In the character's own frame, (pairs, m)."""
    deviations: Array
    """See `Cleaning`, (pairs,)."""
    limits: Array
    """Beyond which it is a conflict where the threshold is "auto", (pairs,)."""
    neighbors: NDArray[np.int32]
    """The pairs that each was compared with, nearest first, (pairs, l)."""

    def __post_init__(self) -> None:
        """Raises StorageError where these do not fit together: a file may have been changed."""
        pairs, columns = len(self.takes), len(self.about.span) or 1
        shapes = {
            "takes": (pairs,),
            "steps": (pairs,),
            "actions": (pairs, columns),
            "deviations": (pairs,),
            "limits": (pairs,),
            "neighbors": (pairs, self.about.n_neighbors),
        }
        whole = all(
            getattr(self, name).shape == shape
            and getattr(self, name).dtype.kind == ("i" if name in _WHOLE else "f")
            for name, shape in shapes.items()
        )
        if whole and pairs:
            names = len(self.about.names)
            whole = self.neighbors.min() >= 0 and self.neighbors.max() < pairs
            if self.about.span:
                whole &= names == columns
            else:
                whole &= bool(np.isin(self.actions, np.arange(names)).all())
        if not whole:
            raise StorageError(
                f"The conflicts of session {self.about.session} are damaged. Look for them again."
            )

    @staticmethod
    def of(about: About, pairs: Pairs, found: Cleaning) -> Conflicts:
        """What a cleaning with the threshold "auto" `found` in `pairs`."""
        return Conflicts(
            about,
            pairs.takes,
            pairs.steps,
            pairs.actions,
            found.deviations,
            found.limits,
            found.eliminator.neighbors().astype(np.int32),
        )

    def limits_at(self, threshold: float | str) -> Array:
        """The deviation beyond which each pair is a conflict, (pairs,). Raises InvalidInputError
        for a threshold that is neither "auto" nor a number above 0."""
        if threshold == "auto":
            return self.limits
        if isinstance(threshold, str) or not 0.0 < threshold < np.inf:
            raise InvalidInputError(
                f"threshold is {threshold!r}; it must be 'auto' or a number above 0."
            )
        return np.full(len(self.limits), float(threshold))

    def marked(self, threshold: float | str) -> Mask:
        """Which pairs are conflicts, (pairs,)."""
        return self.deviations > self.limits_at(threshold)

    def ordered(self, rows: Rows, threshold: float | str) -> Rows:
        """`rows` by how far each is off, beyond its limit, the farthest first."""
        beyond = (self.deviations - self.limits_at(threshold))[rows]
        return rows[np.argsort(-beyond, kind="stable")]

    def going(self, threshold: float | str, verdicts: Verdicts) -> Mask:
        """Which pairs cleaning would leave out after what was said of them, (pairs,)."""
        going = self.marked(threshold)
        for (take, step), verdict in verdicts.items():
            row = self._find(take, step)
            if row is not None:
                going[row] = verdict is Verdict.DELETE
        return going

    def row(self, take: int, step: int) -> int:
        """The place of that pair. Raises NotFoundError where it was not looked at."""
        found = self._find(take, step)
        if found is None:
            raise NotFoundError(
                f"Moment {step} of take {take} was not compared with others. Look for conflicts "
                "again, or choose another."
            )
        return found

    def medians(self, rows: Rows) -> Array:
        """What was usually done in moments like each of `rows`, (rows, m)."""
        span = np.array(self.about.span) if self.about.span else None
        return usual_actions(self.actions[self.neighbors[rows]], span)

    def rows(self, moments: Iterable[tuple[int, int]]) -> Rows:
        """The places of those of `moments`, takes and steps, that were looked at."""
        found = (self._find(take, step) for take, step in moments)
        return np.array([row for row in found if row is not None], dtype=np.int64)

    def among(self, takes: Sequence[int]) -> Mask:
        """Which pairs are of one of `takes`, (pairs,)."""
        return np.isin(self.takes, takes)

    def save(self, workspace: Workspace) -> None:
        """Keep it in place of what was found in the session before. Raises StorageError."""
        about = np.frombuffer(json.dumps(asdict(self.about)).encode(), dtype=np.uint8)
        arrays = {name: getattr(self, name) for name in _ARRAYS}
        write_whole(_path(workspace, self.about.session), pack({"about": about, **arrays}))

    def _find(self, take: int, step: int) -> int | None:
        if not (0 <= take < _MOST and 0 <= step < _MOST):
            return None
        order, keys = self._keys
        key = _key(take, step)
        at = int(np.searchsorted(keys, key))
        return int(order[at]) if at < len(keys) and keys[at] == key else None

    @cached_property
    def _keys(self) -> tuple[Rows, Rows]:
        """The rows in the order of takes and steps, and those as one number each."""
        keys = _key(self.takes, self.steps)
        order = np.argsort(keys, kind="stable")
        return order, keys[order]


_WHOLE = ("takes", "steps", "neighbors")
_ARRAYS = tuple(field.name for field in fields(Conflicts) if field.name != "about")


def find_conflicts(workspace: Workspace, store: str, session: SessionRecord) -> Conflicts:
    """What was found when conflicts were looked for last in a session of the store so named.

    Raises NotFoundError where nobody has looked.
    """
    path = _path(workspace, session.id)
    try:
        found = _read(path, path.stat().st_mtime_ns)
    except (OSError, ValueError, KeyError, TypeError, AttributeError):
        found = None
    if found is None or found.about.store != store:
        raise NotFoundError(
            f"Conflicts have not been looked for in session {session.name!r} so far. Look first."
        )
    return found


@lru_cache(maxsize=READ)
def _read(path: Path, _written_ns: int) -> Conflicts:
    kept = unpack(path.read_bytes(), "file of conflicts")
    told: dict[str, Any] = json.loads(kept.pop("about").tobytes())
    told["seen"] = {int(take): pairs for take, pairs in told["seen"].items()}
    about = About(**{**told, "span": tuple(told["span"]), "names": tuple(told["names"])})
    return Conflicts(about, **kept)


def _key(take: Any, step: Any) -> Any:
    return (take << 32) + step


def _path(workspace: Workspace, session: int) -> Path:
    return workspace.conflicts / f"{session}.safetensors"
