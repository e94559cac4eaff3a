"""Is a known reaction delay found, and what does taking it out win back?

    python -m benchmarks.delay            # the tables in docs/delay.md
    python -m benchmarks.delay --quick    # one set, 50 fields, to see that it runs

The careful scripted demonstrator flies the asteroid field seeing what was there a while ago: the
delay is drawn anew every second, normal about its mean with 0.07 s of jitter, whole steps. It
bridges nothing by foresight. In the second table it flies undelayed and only the recording is
late. Seeds here were not used while the estimate was made: that was demonstration seeds 1 to 3.
"""

from __future__ import annotations

import argparse
import statistics
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import joblib
import numpy as np
from numpy.typing import NDArray

from benchmarks.crossing import FIELDS, MINUTES, middle, scene_at
from benchmarks.report import ROOT, commit, processor
from evastudio.demonstrations.pairs import Pairs, SeenTake, join_pairs, see_take
from evastudio.evaluation.evaluate import evaluate
from evastudio.evaluation.flight import Logbook
from evastudio.learning.delay import Delay, estimate_delay
from evastudio.learning.fitting import fit_policy
from evastudio.pilots.chance import normals
from evastudio.pilots.policy import PolicyPilot
from evastudio.pilots.scripted import find_pilot
from evastudio.world.rollout import Memory, Pilot, roll_out
from evastudio.world.scene import Scene, world_seeds
from evastudio.world.snapshot import Snapshot
from evastudio.world.spaces import Array

DENSITY = 4.0
DELAYS_S = (0.0, 0.1, 0.2, 0.3, 0.4, 0.5)
JITTER_S = 0.07
SETS = (9101, 9102, 9103)
WORLDS = 200
LEARNERS = ("svr",)
LUCK = 77
"""The stream of each world's chance that decides the jitter."""


@dataclass(frozen=True)
class Late(Pilot):
    """`pilot`, seeing the past."""

    pilot: Pilot
    delay_s: float
    name: str = "late"

    def begin(self, scene: Scene, seeds: Sequence[int]) -> Memory:
        count = np.zeros(len(seeds), dtype=np.int64)
        own = {"late.seed": np.array(seeds, dtype=np.uint64), "late.step": count}
        return {**self.pilot.begin(scene, seeds), **own}

    def act(self, scene: Scene, snapshot: Snapshot, memory: Memory) -> tuple[Array, Memory]:
        step = memory["late.step"]
        most = int((self.delay_s + 4 * JITTER_S) / scene.dt_s) + 1
        kept = {"late.seed": memory["late.seed"], "late.step": step + 1}
        for name, now in snapshot.moving.items():
            past = memory.get(f"late.{name}.past", np.repeat(now[:, None], most + 1, axis=1))
            kept[f"late.{name}.past"] = np.concatenate([now[:, None], past[:, :-1]], axis=1)
        lag = drawn_lags(memory["late.seed"], step, self.delay_s, scene.dt_s)
        lag = np.minimum(np.minimum(lag, step), most)
        world = np.arange(snapshot.worlds)
        seen = {name: kept[f"late.{name}.past"][world, lag] for name in snapshot.moving}
        inner = {name: value for name, value in memory.items() if not name.startswith("late.")}
        actions, after = self.pilot.act(scene, Snapshot(snapshot.fixed, seen), inner)
        return actions, {**after, **kept}


def drawn_lags(
    seeds: NDArray[np.uint64], steps: NDArray[np.int64], delay_s: float, dt_s: float
) -> NDArray[np.int64]:
    """The delay of each world at its step, in whole steps, never below 0; none where it is 0."""
    if delay_s == 0.0:
        return np.zeros(len(steps), dtype=np.int64)
    second = (steps * dt_s).astype(np.int64)
    wander = normals(seeds, second, LUCK)[:, 0] * JITTER_S
    return np.maximum(np.rint((delay_s + wander) / dt_s), 0.0).astype(np.int64)


@dataclass(frozen=True)
class Flown:
    """One demonstration set."""

    takes: tuple[SeenTake, ...]
    crossed: float
    """Share of its whole takes that crossed."""

    def pairs(self, delay_steps: int) -> Pairs:
        return join_pairs([take.pairs(delay_steps) for take in self.takes])


def demonstrate(scene: Scene, pilot: Pilot, seed: int, minutes: float) -> Flown:
    """`minutes` flown by `pilot` in whole takes, whatever their end; the last is cut."""
    view = scene.perception("canonical")
    left = round(minutes * 60.0 / scene.dt_s)
    takes: list[SeenTake] = []
    ends = []
    while left > 0:
        world = world_seeds(seed, len(takes) + 1)[-1]
        log = Logbook(scene)
        result = roll_out(scene, pilot, [world], max_steps=left, watcher=log)
        (flight,) = log.flights()
        takes.append(see_take(view, flight.moments, flight.actions, len(takes)))
        left -= len(flight.actions)
        if left > 0:
            ends.append(scene.outcomes[int(result.outcomes[0])] in scene.successes)
    return Flown(tuple(takes), float(np.mean(ends)))


def recorded_late(flown: Flown, delay_s: float, dt_s: float) -> Flown:
    """The same flight, each action written down a while after it was done."""
    takes = []
    for take in flown.takes:
        step = np.arange(len(take), dtype=np.int64)
        seed = np.full(len(take), take.take + 1, dtype=np.uint64)
        lag = np.minimum(drawn_lags(seed, step, delay_s, dt_s), step)
        moved = take.actions[step - lag]
        takes.append(replace(take, actions=moved))
    return Flown(tuple(takes), flown.crossed)


@dataclass(frozen=True)
class Row:
    """What came of one demonstration set."""

    case: str
    delay_s: float
    found: Delay
    spent_s: float
    demonstrator: float
    crossed: Mapping[tuple[str, str], float]
    """By learner and by what it was fitted to: 'raw' or 'taken out'."""


def try_set(case: str, delay_s: float, seed: int, minutes: float, worlds: int) -> Row:
    """Estimate, fit raw and with the delay taken out, fly both."""
    scene = scene_at(DENSITY)
    careful = find_pilot("scripted:careful")
    if case == "flown":
        flown = demonstrate(scene, Late(careful, delay_s), seed, minutes)
    else:
        flown = recorded_late(demonstrate(scene, careful, seed, minutes), delay_s, scene.dt_s)
    start = time.process_time()
    found = estimate_delay(flown.pairs, scene.dt_s)
    spent = time.process_time() - start
    pilots: dict[str, Pilot] = {}
    for learner in LEARNERS:
        for name, steps in (("raw", 0), ("taken out", found.steps)):
            if name == "raw" or steps:
                policy = fit_policy(flown.pairs(steps), scene, "canonical", learner)
                pilots[f"{learner} {name}"] = PolicyPilot(policy)
    results = evaluate(scene, pilots, worlds=worlds, seed=FIELDS).pilots
    rates = {name: result.success_rate for name, result in results.items()}
    crossed = {
        (learner, name): rates.get(f"{learner} {name}", rates[f"{learner} raw"])
        for learner in LEARNERS
        for name in ("raw", "taken out")
    }
    return Row(case, delay_s, found, spent, flown.crossed, crossed)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="one set, 50 fields")
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--out", type=Path, default=ROOT / "docs" / "delay.md")
    given = parser.parse_args()
    sets, worlds = (SETS[:1], 50) if given.quick else (SETS, WORLDS)
    tasks = [
        (case, delay_s, seed)
        for case in ("flown", "recorded")
        for delay_s in DELAYS_S
        for seed in sets
        if case == "flown" or delay_s
    ]
    run = joblib.Parallel(given.jobs, return_as="generator")
    rows = []
    for row in run(joblib.delayed(try_set)(*task, MINUTES, worlds) for task in tasks):
        rows.append(row)
        print(
            row.case,
            row.delay_s,
            f"{row.found.delay_s:.3f}",
            row.found.steps,
            row.crossed,
            flush=True,
        )
    text = report(rows, sets, worlds)
    print(text)
    if not given.quick:
        given.out.write_text(text)


def report(rows: Sequence[Row], sets: Sequence[int], worlds: int) -> str:
    """The tables."""
    at = commit("evastudio/learning", "evastudio/pilots", "scenes")
    lines = [
        "# Reaction delay: found, and taken out",
        "",
        f"Written by `python -m benchmarks.delay` at {at}, on {processor()}.",
        "",
        "The careful scripted demonstrator, a program, answers what it saw a while ago; the delay "
        f"wanders with a standard deviation of {JITTER_S:g} s and it foresees nothing. "
        f"{MINUTES:g} minutes each, {len(sets)} demonstration sets (seeds "
        f"{', '.join(map(str, sets))}), {worlds} unseen fields at NH {DENSITY:g}. Figures are "
        "medians over the sets, with the range. Nothing was chosen by these seeds.",
        "",
        "Won back: of what the delay cost the policy, against the policy from the undelayed "
        "demonstrator, the share that taking it out returns. Where the delay cost less than a "
        "point there is nothing to win and the cell is empty. Where the takes of a set do not "
        "agree that it helps, nothing is taken out: 0 steps.",
    ]
    whole = {
        learner: statistics.median(
            row.crossed[learner, "raw"] for row in rows if row.case == "flown" and not row.delay_s
        )
        for learner in LEARNERS
    }
    titles = {"flown": "Flown with the delay", "recorded": "Only recorded with the delay"}
    for case, title in titles.items():
        columns = "".join(
            f" {learner} raw, % | taken out, % | won back, % |" for learner in LEARNERS
        )
        lines += [
            "",
            f"## {title}",
            "",
            f"| delay, s | found, s | 95 % interval, s | steps taken out | error less by, % "
            f"| demonstrator crossed, % | {columns.lstrip()}",
            "|---" * (6 + 3 * len(LEARNERS)) + "|",
        ]
        for delay_s in DELAYS_S:
            own = [row for row in rows if (row.case, row.delay_s) == (case, delay_s)]
            if not own:
                continue
            cells = [
                f"{delay_s:g}",
                middle([row.found.delay_s for row in own], "{:.3f}"),
                f"{statistics.median(row.found.low_s for row in own):.2f} to "
                f"{statistics.median(row.found.high_s for row in own):.2f}",
                ", ".join(str(row.found.steps) for row in own),
                middle([100 * row.found.gain for row in own], "{:.0f}"),
                middle([100 * row.demonstrator for row in own], "{:.0f}"),
            ]
            for learner in LEARNERS:
                raw = [row.crossed[learner, "raw"] for row in own]
                out = [row.crossed[learner, "taken out"] for row in own]
                lost = whole[learner] - statistics.median(raw)
                won = statistics.median(out) - statistics.median(raw)
                cells += [
                    middle([100 * rate for rate in raw], "{:.1f}"),
                    middle([100 * rate for rate in out], "{:.1f}"),
                    f"{100 * won / lost:.0f}" if lost >= 0.01 else "",
                ]
            lines.append("| " + " | ".join(cells) + " |")
    spent = statistics.median(row.spent_s for row in rows)
    lines += ["", f"One estimate from {MINUTES:g} minutes took {spent:.1f} CPU s.", ""]
    return "\n".join(lines)


if __name__ == "__main__":
    main()
