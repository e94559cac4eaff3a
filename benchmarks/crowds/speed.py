"""How fast a crowd decides all at once, beside a loop that asks scikit-learn for each character.

What `crowd.py` measures; nothing here is run by itself.
"""

from __future__ import annotations

import statistics
import tracemalloc
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import matplotlib as mpl
import numpy as np
from sklearn.neighbors import KNeighborsClassifier

from benchmarks.crowds.walking import CROWD
from benchmarks.motion import FRAMES_HZ, watched
from benchmarks.svr import timed
from evastudio.pilots.guard import GuardedPilot
from evastudio.pilots.policy import PolicyPilot
from evastudio.world.scene import Scene
from evastudio.world.snapshot import Snapshot
from evastudio.world.spaces import Array

mpl.use("svg")
mpl.rcParams["svg.hashsalt"] = "evastudio"
from matplotlib import pyplot  # noqa: E402 - after the choice of how to draw

SIZES = (10, 100, 1000, 10_000, 100_000)
DENSITY = 0.125
ASKED = 300
"""Characters that the loop is timed on where there are more; its time is scaled up."""
SEED = 41
TICK_S = 0.5
"""A crowd decides this often."""
WATCHED_S = 8.0


@dataclass(frozen=True)
class Spent:
    """What something took, of several goes; seconds."""

    cpu_s: float
    """Median."""
    quickest_s: float
    """Least wall time."""


@dataclass(frozen=True)
class Tick:
    """One decision of everybody, and the step after it."""

    people: int
    perceive: Spent
    decide: Spent
    step: Spent
    whole: Spent
    guarded: Spent
    """The whole with the guard."""
    loop: Spent
    """The whole where each character's decision is a call of its own."""
    memory_mb: float
    """The most that looking around held at a time beyond the snapshot."""


def spent(work: Callable[[], object], repeats: int) -> Spent:
    """What `work` takes; once before, untimed."""
    work()
    cpu, wall = zip(*(timed(work)[:2] for _ in range(repeats)), strict=True)
    return Spent(statistics.median(cpu), min(wall))


def scene_of(people: int) -> Scene:
    """The square on which they take an eighth of the cells."""
    return CROWD(people=people, side=max(4, round((people / DENSITY) ** 0.5)), length=3600.0)


def asking_each(pilot: PolicyPilot, states: Array, draws: Array) -> Callable[[], object]:
    """A loop over characters, one call of scikit-learn's for each, drawing among its votes."""
    learner = pilot.policy.learner
    symbols = learner.actions_.argmax(axis=1)
    model = KNeighborsClassifier(learner.k).fit(learner.states_, symbols)
    offset, scale = learner.offset_, learner.scale_

    def loop() -> list[int]:
        chosen = []
        for state, draw in zip(states, draws, strict=True):
            votes = model.predict_proba(((state - offset) / scale)[None])[0]
            chosen.append(int(model.classes_[min(np.cumsum(votes).searchsorted(draw), 3)]))
        return chosen

    return loop


def tick(pilot: PolicyPilot, people: int, repeats: int) -> Tick:
    """What one tick of so many costs, ours and the loop's in turn."""
    scene, guarded = scene_of(people), GuardedPilot(pilot)
    snapshot, memory = scene.worlds([SEED]), pilot.begin(scene, [SEED])
    for _ in range(4):
        actions, memory = pilot.act(scene, snapshot, memory)
        snapshot = scene.step(snapshot, actions)
    view = scene.perceptions[pilot.policy.perception]
    states = view.perceive(snapshot).states[0]
    draws = np.random.default_rng(people).random(people)
    asked = min(people, ASKED)
    loop = asking_each(pilot, states[:asked], draws[:asked])
    perceive = spent(lambda: view.perceive(snapshot), repeats)
    decide = spent(lambda: pilot.policy.learner.decide(states, draws), repeats)
    step = spent(lambda: scene.step(snapshot, actions), repeats)
    whole = spent(lambda: scene.step(snapshot, pilot.act(scene, snapshot, memory)[0]), repeats)
    safe = spent(lambda: scene.step(snapshot, guarded.act(scene, snapshot, memory)[0]), repeats)
    each = spent(loop, max(2, repeats // 8))
    slow = Spent(
        *(
            getattr(perceive, name) + getattr(step, name) + getattr(each, name) * people / asked
            for name in ("cpu_s", "quickest_s")
        )
    )
    tracemalloc.start()
    view.perceive(snapshot)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    return Tick(people, perceive, decide, step, whole, safe, slow, peak / 1e6)


def shown(pilot: PolicyPilot, people: int) -> tuple[float, float]:
    """CPU ms a frame and frames a second, as one browser watches the crowd walk at 30 Hz.

    Limbs and messages are counted, decisions are not: they were made before.
    """
    scene = scene_of(people)
    snapshot, memory = scene.worlds([SEED]), pilot.begin(scene, [SEED])
    moments = [snapshot]
    for _ in range(round(WATCHED_S / TICK_S)):
        actions, memory = pilot.act(scene, snapshot, memory)
        snapshot = scene.step(snapshot, actions)
        moments.append(snapshot)

    def at(time_s: float) -> Snapshot:
        number, share = divmod(time_s / TICK_S, 1.0)
        before = min(int(number), len(moments) - 2)
        return scene.interpolate(moments[before], moments[before + 1], share)

    return watched(scene, at)


def measure(pilot: PolicyPilot, quick: bool) -> tuple[list[Tick], dict[int, tuple[float, float]]]:
    """Ticks of all sizes, and what showing costs."""
    sizes = SIZES[:3] if quick else SIZES
    ticks = [tick(pilot, people, 9 if people > 20_000 or quick else 41) for people in sizes]
    return ticks, {people: shown(pilot, people) for people in ((100,) if quick else (200, 1000))}


def told(ticks: Sequence[Tick], views: dict[int, tuple[float, float]], opening: str) -> list[str]:
    """The section, in Markdown."""
    lines = [
        "## How fast a crowd is",
        "",
        "Written by `make bench-crowd`; do not edit by hand.",
        "",
        opening,
        "- A tick is one decision of everybody (perceive and decide) and the step after it, with "
        "`crowd-hurried` on a ground of which an eighth is taken; twice a second it is due. "
        "CPU of the process, median, and the quickest wall time; deciding uses all processors, the "
        "rest one.",
        "- The loop asks scikit-learn's `KNeighborsClassifier` for each character and draws among "
        f"its votes; it is timed on {ASKED} characters and scaled where there are more, and what "
        "everybody perceives and the step are ours and batched on both sides.",
        "- Memory: the most that looking around held at a time, beyond the snapshot.",
        "- Machines here are shared: wall times hold what else ran, so the curve shows CPU time.",
        "",
        "![CPU time of a tick over the number of people](crowd.svg)",
        "",
        "| people | perceive, CPU | decide, CPU | step, CPU | whole tick, CPU | wall "
        "| with the guard, CPU | wall | loop, CPU | wall | loop / whole, CPU | wall | memory |",
        "|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|",
    ]
    for one in ticks:
        parts = [one.perceive.cpu_s, one.decide.cpu_s, one.step.cpu_s]
        parts += [one.whole.cpu_s, one.whole.quickest_s]
        parts += [one.guarded.cpu_s, one.guarded.quickest_s, one.loop.cpu_s, one.loop.quickest_s]
        cells = [f"{1e3 * part:,.2f} ms" for part in parts]
        cells.append(f"{one.loop.cpu_s / one.whole.cpu_s:,.0f}x")
        cells.append(f"{one.loop.quickest_s / one.whole.quickest_s:,.0f}x")
        lines.append(f"| {one.people:,} | {' | '.join(cells)} | {one.memory_mb:.1f} MB |")
    lines += [
        "",
        "Shown at 30 Hz to one browser, limbs and messages; decisions, two a second, were made "
        "before (at most 40 % of a core for 1,000 people are allowed, 20 ms for a tick of 10,000):",
        "",
        "| people | CPU a frame | of one core | frames a second |",
        "|---:|---:|---:|---:|",
    ]
    for people, (frame_ms, rate) in views.items():
        share = frame_ms * FRAMES_HZ / 10
        lines.append(f"| {people:,} | {frame_ms:.1f} ms | {share:.0f} % | {rate:.0f} |")
    return lines


def draw(ticks: Sequence[Tick], path: Path) -> None:
    """CPU time of a tick over the number of people."""
    sizes = [one.people for one in ticks]
    figure, axes = pyplot.subplots(figsize=(7, 4))
    for label, values in (
        ("one call for each, scikit-learn", [1e3 * one.loop.cpu_s for one in ticks]),
        ("all at once, with the guard", [1e3 * one.guarded.cpu_s for one in ticks]),
        ("all at once", [1e3 * one.whole.cpu_s for one in ticks]),
    ):
        axes.plot(sizes, values, marker="o", label=label)
    axes.axhline(1e3 * TICK_S, color="gray", linestyle=":", linewidth=1)
    axes.text(sizes[0], 1e3 * TICK_S * 1.15, "the next decision is due", color="gray", fontsize=8)
    axes.set(xscale="log", yscale="log", xlabel="people", ylabel="CPU time of a tick, ms")
    axes.grid(alpha=0.3)
    axes.legend(frameon=False)
    figure.savefig(path, bbox_inches="tight", metadata={"Date": None})
    pyplot.close(figure)
