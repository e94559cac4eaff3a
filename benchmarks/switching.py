"""Is a switch learned from ten marked demonstrations the one that the demonstrator had in mind?

    python -m benchmarks.switching            # the table and figure in docs/switching.md
    python -m benchmarks.switching --quick    # ten unseen runs for each rule, written nowhere

A scripted demonstrator walks in the crowd, lets the boulder fall at a moment drawn by chance where
the rule needs it, and marks the moments when a written rule begins or ceases to hold. From ten such
takes a condition is learned that may look at every sign of the scene, the time and the perception
`paths`, without being told which of them matters. Then policies take turns by that condition in
worlds that nobody has seen, and along each run it is noted when the switch fell and when the rule
would have had it. Beside it, from the same takes: a decision tree (also with classes weighed
alike), logistic regression and voting k-NN that tell the moments before the mark from those after
it; of these a switch is for good too where no take has a second mark.
"""

from __future__ import annotations

import argparse
import time
import warnings
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from sklearn.exceptions import ConvergenceWarning
from sklearn.linear_model import LogisticRegression
from sklearn.neighbors import KNeighborsClassifier
from sklearn.pipeline import make_pipeline
from sklearn.preprocessing import StandardScaler
from sklearn.tree import DecisionTreeClassifier

from benchmarks.report import ROOT, commit, where_and_when, write_section
from evastudio.learning.switch import Entry, Switch
from evastudio.learning.switching import MarkedTakes, Mask, learn_switch
from evastudio.live.headless import make_scene
from evastudio.live.piloting import load_switchboard
from evastudio.pilots.scripted import find_pilot
from evastudio.pilots.switchboard import Switchboard
from evastudio.pilots.watching import HELD, Watch
from evastudio.workspace import Workspace
from evastudio.world.cast import of_lead
from evastudio.world.conditions import SECONDS, Condition, parse_condition, read
from evastudio.world.rollout import Memory, Pilot, roll_out
from evastudio.world.scene import Scene, world_seeds
from evastudio.world.snapshot import Snapshot
from evastudio.world.spaces import Array

DEMONSTRATIONS, RUNS = 10, 60
SHOWN, UNSEEN = 301, 302
"""Seeds, not used while the learning was made: that was 1 and 77."""
PERCEPTION = "paths"
PEERS = {
    "tree": DecisionTreeClassifier(max_depth=4, random_state=0),
    "tree, weighed": DecisionTreeClassifier(max_depth=4, class_weight="balanced", random_state=0),
    "logistic": make_pipeline(StandardScaler(), LogisticRegression(max_iter=2000)),
    "voting k-NN": make_pipeline(StandardScaler(), KNeighborsClassifier(5)),
}
FAR = 100.0
"""Metres that stand for no boulder, for peers that would be blinded by a larger number."""


@dataclass(frozen=True)
class Rule:
    """What the demonstrator goes by."""

    words: str
    text: str
    demonstrator: str
    then: str = "crowd-fleeing"
    """The policy that follows on `crowd-hurried`."""


RULES = (
    Rule("the impact", "event:impact", "scripted:surprised"),
    Rule("20 s have passed", "after:20s", "scripted:surprised", "crowd-shy"),
    Rule("west of 4.5 m", "once x<4.5", "scripted:hurried", "crowd-shy"),
    Rule("in the square", "once region:3.1,3.1,10.1,10.1", "scripted:hurried", "crowd-shy"),
    Rule("while in the square", "region:3.1,3.1,10.1,10.1", "scripted:hurried", "crowd-shy"),
    Rule("12 m from the boulder", "once event:impact and boulder>12", "scripted:surprised"),
)


class Frightened(Pilot):
    """Acts as `pilot`, while the lead lets the boulder fall as `demonstrator` does."""

    def __init__(self, pilot: Pilot, demonstrator: Pilot) -> None:
        self.pilot, self.demonstrator, self.name = pilot, demonstrator, pilot.name

    def begin(self, scene: Scene, seeds: Sequence[int]) -> Memory:
        return self.pilot.begin(scene, seeds)

    def act(self, scene: Scene, snapshot: Snapshot, memory: Memory) -> tuple[Array, Memory]:
        actions, memory = self.pilot.act(scene, snapshot, memory)
        seeds = [0] * snapshot.worlds
        wanted, _ = self.demonstrator.act(scene, snapshot, self.demonstrator.begin(scene, seeds))
        actions = actions.copy()
        actions[:, :, 2:5] = wanted[:, :, 2:5]
        return actions, memory


def runs(
    scene: Scene,
    pilot: Pilot,
    rule: Condition,
    seeds: Sequence[int],
    board: Switchboard | None = None,
) -> tuple[MarkedTakes, Mask, float]:
    """Runs of `pilot` with the lead's marks by `rule`; where `board` acted by its first entry for
    the lead, (moments,); and in what share of everybody's runs it kept to the rule."""
    watch = Watch((rule,))
    memory = watch.begin(scene, len(seeds))
    shown: Memory = {} if board is None else board.begin(scene, seeds)
    names = [sign.name for sign in scene.signs] + [SECONDS.name]
    names += [f"{PERCEPTION}.{one.name}" for one in scene.perception(PERCEPTION).state.fields]
    kept: list[list[tuple[Array, bool, bool]]] = [[] for _ in seeds]
    crowd: list[list[tuple[Array, Array]]] = [[] for _ in seeds]

    def look(alive: Any, snapshot: Snapshot, _: Array) -> None:
        nonlocal memory, shown
        here = {name: array[alive] for name, array in memory.items()}
        before = here[HELD][..., 0]
        seconds = here["steps"] * scene.dt_s
        told = read(scene, snapshot, seconds, names)
        table = np.stack([of_lead(snapshot, told[name]) for name in names], axis=1)
        holds, after = watch.look(scene, snapshot, here)
        acting = np.ones(holds.shape[:-1], dtype=np.int64)
        if board is not None:
            own = {name: array[alive] for name, array in shown.items()}
            acting, watched = board.acting(scene, snapshot, own)
            shown = {**shown, **{name: _put(shown[name], alive, watched[name]) for name in watched}}
        memory = {name: _put(memory[name], alive, after[name]) for name in memory}
        marks = of_lead(snapshot, holds[..., 0] ^ before)
        first = of_lead(snapshot, acting) == 0
        for row, world in enumerate(alive):
            kept[world].append((table[row], bool(marks[row]), bool(first[row])))
            crowd[world].append((holds[row, ..., 0], acting[row] == 0))

    roll_out(scene, pilot, seeds, watcher=look)
    lengths = np.array([len(run) for run in kept])
    rows = [moment for run in kept for moment in run]
    takes = MarkedTakes(
        tuple(names),
        np.array([row[0] for row in rows]),
        lengths,
        np.array([row[1] for row in rows]),
    )
    return takes, np.array([row[2] for row in rows]), _everybody(crowd)


def _put(array: Any, rows: Any, values: Any) -> Any:
    changed = array.copy()
    changed[rows] = values
    return changed


def _everybody(crowd: list[list[tuple[Array, Array]]]) -> float:
    """In what share of the runs of all characters every switch fell within one decision."""
    good = []
    for run in crowd:
        holds, acting = (np.array([moment[part] for moment in run]) for part in (0, 1))
        for person in range(holds.shape[1]):
            marks = np.diff(holds[:, person].astype(int), prepend=0) != 0
            one = MarkedTakes((), np.zeros((len(marks), 0)), np.array([len(marks)]), marks)
            good.append(bool(one.near(acting[:, person])[0]))
    return float(np.mean(good))


def board_of(scene: Scene, rule: Rule, condition: Condition) -> Switchboard:
    """A switchboard between shipped policies."""
    entries = (Entry(rule.then, condition), Entry("crowd-hurried", None))
    identity = {"name": scene.name, "version": scene.version}
    return load_switchboard(Workspace(Path()), Switch(entries, identity), scene)


def measured(scene: Scene, rule: Rule, count: int) -> dict[str, Any]:
    """One row of the table."""
    meant = parse_condition(rule.text, scene)
    demonstrator = find_pilot(rule.demonstrator)
    takes, _, _ = runs(scene, demonstrator, meant, world_seeds(SHOWN, DEMONSTRATIONS))
    begins = time.process_time()
    learned = learn_switch(takes)
    seconds = time.process_time() - begins
    board = board_of(scene, rule, learned.condition)
    pilot = Frightened(board, demonstrator)
    unseen, acting, everybody = runs(scene, pilot, meant, world_seeds(UNSEEN, count), board)
    row = {
        "rule": rule,
        "marks": learned.marks,
        "learned": learned,
        "words": learned.condition.words(scene),
        "seconds": seconds,
        "near": float(unseen.near(acting).mean()),
        "exact": float(_exact(unseen, acting)),
        "everybody": everybody,
        "offsets": _offsets(unseen, acting),
    }
    for name, peer in PEERS.items():
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", ConvergenceWarning)
            peer.fit(_near_only(takes), takes.after)
        says = unseen.acting(peer.predict(_near_only(unseen)).astype(bool), takes.once)
        row[name] = float(unseen.near(says).mean())
    return row


def _near_only(takes: MarkedTakes) -> Array:
    return np.minimum(takes.readings, FAR)


def _exact(takes: MarkedTakes, acting: Mask) -> float:
    good = [
        np.array_equal(takes.after[start : start + length], acting[start : start + length])
        for start, length in zip(takes.starts, takes.lengths, strict=True)
    ]
    return float(np.mean(good))


def _offsets(takes: MarkedTakes, acting: Mask) -> list[int]:
    """Decisions by which the first switch of each run came late (negative: early)."""
    return [int(late) for late in takes.first(acting) - takes.first(takes.marks)]


def table(rows: list[dict[str, Any]], count: int) -> str:
    lines = [
        f"## Switches learned from {DEMONSTRATIONS} marked demonstrations, on {count} unseen runs",
        "",
        "| the demonstrator's rule | marks | learned | within one decision | exactly | everybody "
        f"| {' | '.join(PEERS)} | CPU s |",
        "|---" * (7 + len(PEERS)) + "|",
    ]
    for row in rows:
        peers = " | ".join(f"{row[name]:.0%}" for name in PEERS)
        lines.append(
            f"| {row['rule'].words} (`{row['rule'].text}`) | {row['marks']} | {row['words']} | "
            f"**{row['near']:.0%}** | {row['exact']:.0%} | {row['everybody']:.0%} | {peers} | "
            f"{row['seconds']:.1f} |"
        )
    return "\n".join(lines)


def draw(rows: list[dict[str, Any]], path: Path) -> None:
    """How early or late the switch came, a panel for each rule."""
    import matplotlib as mpl

    mpl.use("Agg")
    from matplotlib import pyplot as plt

    figure, panels = plt.subplots(1, len(rows), figsize=(2.1 * len(rows), 2.4), sharey=True)
    for panel, row in zip(panels, rows, strict=True):
        late = np.clip(row["offsets"], -5, 5)
        panel.axvspan(-1.5, 1.5, color="#dfeee2")
        panel.hist(late, bins=np.arange(-5.5, 6.5), color="#3b6ea5")
        panel.set_title(f"{row['rule'].words}\n{row['near']:.0%} within one", fontsize=8)
        panel.set_xlabel("decisions late", fontsize=8)
        panel.tick_params(labelsize=7)
    panels[0].set_ylabel("unseen runs", fontsize=8)
    figure.tight_layout()
    figure.savefig(path, metadata={"Date": None})


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--quick", action="store_true")
    quick = parser.parse_args().quick
    at = commit("evastudio", "scenes", "policies", "benchmarks/switching.py")
    start = time.monotonic()
    scene = make_scene(Workspace(Path()), "crowd")
    rows = []
    for rule in RULES:
        rows.append(measured(scene, rule, 10 if quick else RUNS))
        print(f"{rule.words}: {rows[-1]['near']:.0%}, {rows[-1]['words']}", flush=True)
    text = table(rows, 10 if quick else RUNS)
    if quick:
        print(text)
        return
    command = "python -m benchmarks.switching"
    path = ROOT / "docs" / "switching.md"
    draw(rows, ROOT / "docs" / "switching.svg")
    head = where_and_when(at, command, time.monotonic() - start)
    figure = "![How early or late the switch came](switching.svg)"
    write_section(path, "measured", f"{head}\n\n{text}\n\n{figure}")


if __name__ == "__main__":
    main()
