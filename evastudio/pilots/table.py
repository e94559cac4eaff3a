"""Reinforcement learning by tables: the state is cut into cells, and each has a value.

The paper reckons that this cannot be done at the size of its case study (4.1, table 2);
`table_bytes` does its arithmetic, and `learn_table` does the thing itself where it is small.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_matrix

from evastudio.errors import InvalidInputError
from evastudio.world.practice import Practice
from evastudio.world.rollout import Memory, Pilot
from evastudio.world.scene import Perception, Scene
from evastudio.world.snapshot import Snapshot
from evastudio.world.spaces import Array, Box, finite_rows

Cells = NDArray[np.int64]

MOST_CELLS = 20_000_000
"""More cells are refused: their tables would not fit in an ordinary machine."""
BYTES = 8
"""Of one value."""
TURNS = np.array([(x, y) for x in (-1.0, 0.0, 1.0) for y in (-1.0, 0.0, 1.0)])
"""The nine actions of a table of a character with two: each at its lowest, rest or highest."""


def table_bytes(dimensions: int, divisions: int, actions: int) -> tuple[int, int, int]:
    """Cells of a state of so many `dimensions`, the bytes of their values V, and of Q."""
    cells = divisions**dimensions
    return cells, cells * BYTES, cells * BYTES * actions


@dataclass(frozen=True)
class Grid:
    """A state space cut into cells, along every dimension into as many."""

    edges: Array
    """Where it is cut, ascending, shape (dimensions, divisions - 1)."""

    def __post_init__(self) -> None:
        if self.edges.ndim != 2 or (np.diff(self.edges, axis=1) < 0.0).any():
            raise InvalidInputError("A grid needs the same number of rising edges everywhere.")
        if self.cells > MOST_CELLS:
            raise InvalidInputError(
                f"A grid of {self.edges.shape[1] + 1} divisions in {len(self.edges)} dimensions "
                f"has {self.cells:,} cells, and at most {MOST_CELLS:,} fit; choose fewer divisions."
            )

    @classmethod
    def of(cls, states: Array, divisions: int) -> Grid:
        """Cut so that along each dimension as many of `states` (rows, n) lie in each part."""
        if divisions < 1:
            raise InvalidInputError(f"{divisions} divisions were asked for; choose at least 1.")
        states = finite_rows(states, np.shape(states)[-1], "states")
        shares = np.arange(1, divisions) / divisions
        return cls(np.quantile(states, shares, axis=0).T)

    @property
    def cells(self) -> int:
        """How many there are."""
        return int((self.edges.shape[1] + 1) ** len(self.edges))

    def cell(self, states: Array) -> Cells:
        """In which cell each of `states` (rows, n) lies, (rows,)."""
        divisions = self.edges.shape[1] + 1
        found = np.zeros(len(states), dtype=np.int64)
        for edges, column in zip(self.edges, states.T, strict=True):
            found = found * divisions + np.searchsorted(edges, column, side="right")
        return found


class TablePilot(Pilot):
    """Takes the best-valued action of the cell that the state lies in."""

    name = "table"

    def __init__(self, perception: str, grid: Grid, actions: Array, values: Array) -> None:
        """`actions` (k, m) are in the frame of `perception`, `values` (cells, k) those of Q."""
        self.perception = perception
        self.grid = grid
        self.actions = actions
        self.best = values.argmax(axis=1)

    def act(self, scene: Scene, snapshot: Snapshot, memory: Memory) -> tuple[Array, Memory]:
        view = scene.perception(self.perception)
        percept = view.perceive(snapshot)
        chosen = self.actions[self.best[self.grid.cell(percept.states)]]
        return view.to_world(percept.frame, chosen), memory


@dataclass(frozen=True)
class Learned:
    """What practice at a table came to."""

    pilot: TablePilot
    cells_seen: int
    """Cells that a world was in at least once."""
    pairs_seen: int
    """Cells and actions, of those that there are, tried at least once."""
    stored_bytes: int
    """Of Q and of the transitions counted."""


def learn_table(
    scene: Scene,
    perception: str,
    divisions: int,
    *,
    steps: int,
    seed: int,
    worlds: int = 128,
    rounds: int = 10,
    discount: float = 0.98,
    explore: float = 0.2,
    progress: Callable[[int, TablePilot], None] | None = None,
) -> Learned:
    """Value iteration over the transitions seen in `steps` decisions of practice.

    As in certainty equivalence: act by the values so far, but at random in a share `explore` of
    the decisions and where a cell's actions are untried; after each of `rounds` count what was
    seen and solve for Q (R. Sutton, A. Barto, "Reinforcement learning", 2018, 4.4 and 8.2). The
    grid is cut by the states of straight and of random flight. `progress` hears the steps so far
    and the pilot. Raises InvalidInputError for an action that is symbols or has not two
    components, and for a grid too large.
    """
    view = scene.perception(perception)
    if not isinstance(scene.chosen(view), Box) or scene.action.size != 2:
        raise InvalidInputError(
            f"A table is learned for two actions that are numbers; scene {scene.name!r} has others."
        )
    actions = TURNS * scene.action.high
    rng = np.random.default_rng(seed)
    grid = Grid.of(_looked_around(scene, view, actions, worlds, seed + 1, rng), divisions)
    seen = Counted(grid.cells, len(actions))
    practice = Practice(scene, view, worlds=worlds, seed=seed)
    values = np.zeros((grid.cells, len(actions)))
    here = grid.cell(practice.states)
    for done in range(1, rounds + 1):
        for _ in range(max(1, steps // (worlds * rounds))):
            best = values[here] + 1e-9 * rng.random((worlds, len(actions)))
            at_random = rng.random(worlds) < explore
            chosen = np.where(at_random, rng.integers(len(actions), size=worlds), best.argmax(1))
            told = practice.step(actions[chosen])
            there = grid.cell(told.states)
            seen.add(here, chosen, there, told.rewards, told.outcomes != 0)
            here = there
        values = seen.solve(discount, values)
        if progress is not None:
            pilot = TablePilot(view.name, grid, actions, seen.known(values))
            progress(done * worlds * max(1, steps // (worlds * rounds)), pilot)
    pilot = TablePilot(view.name, grid, actions, seen.known(values))
    tried = seen.counts.reshape(values.shape) > 0
    return Learned(
        pilot, int(tried.any(axis=1).sum()), int(tried.sum()), values.nbytes + seen.stored_bytes
    )


def _looked_around(
    scene: Scene, view: Perception, actions: Array, worlds: int, seed: int, rng: np.random.Generator
) -> Array:
    """States (rows, n) on the way ahead, every other world turning at random now and then."""
    practice = Practice(scene, view, worlds=worlds, seed=seed)
    states = []
    straight = len(actions) // 2
    for _ in range(200):
        chosen = np.where(
            rng.random(worlds) < 0.2, rng.integers(len(actions), size=worlds), straight
        )
        chosen[::2] = straight
        states.append(practice.step(actions[chosen]).states)
    return np.concatenate(states)


class Counted:
    """Transitions counted, and the values that follow from them."""

    def __init__(self, cells: int, actions: int) -> None:
        self.shape = (cells, actions)
        self.counts = np.zeros(cells * actions, dtype=np.int64)
        self._earned = np.zeros(cells * actions)
        self._new: list[tuple[Cells, Cells]] = []
        self._leads = csr_matrix((cells * actions, cells))

    @property
    def stored_bytes(self) -> int:
        """Of everything that is counted."""
        leads = self._leads
        own = leads.data.nbytes + leads.indices.nbytes + leads.indptr.nbytes
        return int(self.counts.nbytes + self._earned.nbytes + own)

    def add(
        self, here: Cells, chosen: Cells, there: Cells, rewards: Array, ended: NDArray[np.bool_]
    ) -> None:
        pairs = here * self.shape[1] + chosen
        np.add.at(self.counts, pairs, 1)
        np.add.at(self._earned, pairs, rewards)
        self._new.append((pairs[~ended], there[~ended]))

    def solve(self, discount: float, values: Array, within: float = 1e-3) -> Array:
        """Q (cells, actions), to `within`, going on from `values`; 0 of what was never tried."""
        pairs, there = (np.concatenate(part) for part in zip(*self._new, strict=True))
        self._new.clear()
        self._leads = self._leads + csr_matrix(
            (np.ones(len(pairs)), (pairs, there)), shape=self._leads.shape
        )
        times = np.maximum(self.counts, 1)
        earned = self._earned / times
        while True:
            ahead = self._leads @ values.max(axis=1)
            better = (earned + discount * ahead / times).reshape(self.shape)
            if np.abs(better - values).max() < within * (1.0 - discount):
                return np.asarray(better)
            values = better

    def known(self, values: Array) -> Array:
        """`values` where they were tried; what was not is never chosen before what was."""
        tried = self.counts.reshape(self.shape) > 0
        return np.where(tried, values, -np.inf)
