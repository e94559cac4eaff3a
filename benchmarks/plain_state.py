"""The map of `benchmarks/reproduction.py`: who shows what to whom, in which field."""

from __future__ import annotations

import hashlib
import re
import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path

from evastudio.evaluation.results import Evaluation
from evastudio.pilots.traits import STYLES, Traits
from evastudio.workspace import shipped
from evastudio.world.loading import load_scene_file
from evastudio.world.scene import Scene

DENSITIES = (1.0, 2.0, 4.0)
STUDY = """

from benchmarks.two_nearest import ladder, turn_away

WALLS = True


class Study(Asteroids):
    def __init__(self, **values):
        super().__init__(**values)
        self.perceptions = {**self.perceptions, **ladder(self.perceptions["paper"], REACH)}

    def intention(self, snapshot, *, two_nearest=0.0, **traits):
        if not two_nearest:
            return super().intention(snapshot, **traits)
        states = self.perceptions["paper"].perceive(snapshot).states
        return self.action.clip(turn_away(states, ship_axes(states[:, :2]), REACH))

    def outcome(self, snapshot):
        if WALLS:
            return super().outcome(snapshot)
        position = snapshot["position"].copy()
        position[:, 1:] = 0.0
        ended = super().outcome(snapshot.after(position=position))
        hit = nearest_square(snapshot, REACH) < REACH**2
        return np.where(hit, 2, np.where(ended == 2, 0, ended))


SCENE = Study
"""
"""What is added to the text of the scene's file; it runs there."""


@dataclass(frozen=True)
class Cell:
    """One place on the map: who showed what to whom, and where it was flown."""

    demonstrator: str = "two nearest"
    learner: str = "svr"
    perception: str = "paper"
    pairs: int = 6000
    shown_at: float = 4.0
    """NH of the demonstration."""
    flown_at: tuple[float, ...] = (4.0,)
    """NHs it is tried in."""
    constants: tuple[tuple[str, str], ...] = ()
    """Those of the scene's file that are others, as they stand there."""

    def scene(self, density: float) -> Scene:
        """The field of this cell."""
        return variant(self.constants)(density=density, half_width=100.0)


@dataclass(frozen=True)
class Found:
    """What became of a cell; of each NH the evaluations of its sets."""

    setting: str
    policies: Mapping[float, Sequence[Evaluation]]


DEMONSTRATORS: Mapping[str, Traits] = {
    "careful": STYLES["careful"],
    "two nearest": Traits(intention={"two_nearest": 1.0}),
    "two nearest, human hand": replace(STYLES["human"], intention={"two_nearest": 1.0}),
}
"""All are programs. The second's actions are a function of the paper's state."""


@cache
def variant(constants: tuple[tuple[str, str], ...]) -> type[Scene]:
    """The shipped field with other `constants` and what STUDY adds."""
    text = (shipped() / "scenes" / "asteroids.py").read_text(encoding="utf-8") + STUDY
    for name, value in constants:
        text, found = re.subn(rf"(?m)^{name} = .*$", f"{name} = {value}", text)
        assert found == 1, f"{name} is no constant of the asteroid field"
    stem = "field_" + hashlib.sha256(text.encode()).hexdigest()[:12]
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / f"{stem}.py"
        path.write_text(text, encoding="utf-8")
        return load_scene_file(path)


def with_constants(**constants: str) -> Cell:
    return Cell(constants=tuple(constants.items()))


FACTORS: Mapping[str, Cell] = {
    "as it is: rocks 3 m, 10 m/s, 6 degrees, 6,000 pairs, shown at NH 4": Cell(),
    "rocks of 1.5 m": with_constants(ROCK_RADIUS="1.5"),
    "rocks of 6 m": with_constants(ROCK_RADIUS="6.0"),
    "rocks of 12 m": with_constants(ROCK_RADIUS="12.0"),
    "20 m/s": with_constants(SPEED="20.0", TIME_LIMIT_S="45.0"),
    "turns of 3 degrees": with_constants(TURN="np.radians(3.0)"),
    "turns of 12 degrees": with_constants(TURN="np.radians(12.0)"),
    "1,500 pairs": Cell(pairs=1500),
    "24,000 pairs": Cell(pairs=24_000),
    "shown at NH 1": Cell(shown_at=1.0),
    "shown at NH 8": Cell(shown_at=8.0),
    "no walls": with_constants(WALLS="False"),
}
"""One thing changed at a time; all flown at NH 4."""
BEST = Cell(pairs=24_000, shown_at=8.0, flown_at=DENSITIES)
"""Everything that helped, together."""
STATES: Mapping[str, Sequence[str]] = {
    "careful": (
        "paper",
        "own frame",
        "fading",
        "ahead",
        "own frame, fading",
        "own frame, fading, ahead",
        "canonical",
    ),
    "two nearest": ("paper", "own frame", "fading", "own frame, fading"),
}
"""What else each demonstrator's answers are learned from."""
RAW = ("knn, radians", "knn, degrees", "svr, radians", "svr, degrees")
PLAIN = ("knn", "svr")


def whole_map() -> list[Cell]:
    """Every cell with a learner in it, once."""
    cells = [Cell(who, learner, flown_at=DENSITIES) for who in DEMONSTRATORS for learner in PLAIN]
    cells += [replace(cell, learner=how) for cell in FACTORS.values() for how in PLAIN]
    cells += [replace(BEST, learner=how) for how in PLAIN]
    cells += [Cell(learner=learner) for learner in RAW]
    cells += [
        Cell(who, learner, state)
        for who, states in STATES.items()
        for state in states
        for learner in PLAIN
    ]
    return [cell for cell in dict.fromkeys(cells) if not _part_of_other(cell, cells)]


def _part_of_other(cell: Cell, cells: Sequence[Cell]) -> bool:
    whole = replace(cell, flown_at=DENSITIES)
    return cell != whole and whole in cells


def references() -> list[Cell]:
    """Every cell flown without a policy."""
    every = [Cell(who, "itself", flown_at=DENSITIES) for who in (*DEMONSTRATORS, "straight")]
    return every + [replace(c, learner="itself") for c in FACTORS.values() if c.constants]
