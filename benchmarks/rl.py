"""What does reinforcement learning give, and what does it cost: by networks, and by tables?

    python -m benchmarks.rl              # the section in docs/baselines.md, docs/rl.svg
    python -m benchmarks.rl --quick      # 20,000 decisions, to see that it runs

PPO practises in the asteroid field of the tables in docs/results.md, under both perceptions, with
the reward of the scene's Gymnasium environment, and with a cost of turning. Its settings were
chosen on the 200 fields of seed 777; figures are from the same fields as in docs/results.md.
"""

from __future__ import annotations

import argparse
import os
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import joblib
import matplotlib as mpl
import numpy as np

from benchmarks.crossing import FIELDS, ROOT, SETS, SHOWN_AT, demonstrate, middle, scene_at
from benchmarks.layers import Layers
from benchmarks.report import commit, where_and_when, write_section
from evastudio.evaluation.interval import wilson_interval
from evastudio.learning.policy import Policy
from evastudio.learning.policy_files import save_policy
from evastudio.pilots.policy import PolicyPilot
from evastudio.pilots.ppo import PPO, Lesson
from evastudio.pilots.scripted import find_pilot
from evastudio.pilots.table import learn_table, table_bytes
from evastudio.world.rollout import Pilot, roll_out
from evastudio.world.scene import Scene, world_seeds

mpl.use("svg")
mpl.rcParams["svg.hashsalt"] = "evastudio"
from matplotlib import pyplot  # noqa: E402 - after the choice of how to draw

TRAINED = ROOT / "benchmarks" / "trained"
CURVE_FIELDS = 778
"""Seed of the unseen fields of the learning curves."""
VARIANTS = {
    "canonical, reward as it is": ("canonical", 0.0, 300_000),
    "canonical, turning costs": ("canonical", 0.002, 300_000),
    "paper, reward as it is": ("paper", 0.0, 1_000_000),
}
"""What PPO is run with: perception, cost of turning, decisions."""
TABLES = (("canonical", (2, 3, 4, 6)), ("paper", (2, 3, 4)))
TABLE_SEEDS = (1, 2, 3)
TABLED = 200_000
"""Decisions practised for a table."""
PARTS = ("ppo", "tables", "imitation")
DISCOUNT = 0.95
"""Of the tables: the best of .9, .95, .98 and .99 at 3 divisions."""


@dataclass(frozen=True)
class Crossed:
    """How one pilot did in the same fields as all others."""

    crossed: int
    fields: int
    steps: float
    """Mean decisions of those that crossed."""
    turn: float
    """Mean change of action, share of its range."""

    @property
    def told(self) -> str:
        """The rate in % with its interval, seconds to cross, turn in %: cells of a table."""
        low, high = wilson_interval(self.crossed, self.fields)
        rate = f"{100 * self.crossed / self.fields:.1f} ({100 * low:.1f} to {100 * high:.1f})"
        seconds = f"{self.steps / 15:.1f}" if self.crossed else ""
        return f"{rate} | {seconds} | {100 * self.turn:.1f}"


def fly(scene: Scene, pilot: Pilot, seed: int, fields: int) -> Crossed:
    """`pilot` in that many fields that follow from `seed`."""
    flown = roll_out(scene, pilot, world_seeds(seed, fields))
    good = flown.outcomes == scene.outcomes.index("crossed")
    steps = float(flown.steps[good].mean()) if good.any() else 0.0
    return Crossed(int(good.sum()), fields, steps, float(flown.turn.mean()))


# -- by networks ---------------------------------------------------------------------------------


@dataclass(frozen=True)
class Practised:
    """One run of PPO."""

    variant: str
    seed: int
    curve: list[tuple[int, float, float]]
    """Decisions, CPU seconds, share of fields crossed."""
    policy: Policy
    result: Crossed

    def reached(self, share: float) -> tuple[int, float] | None:
        """Decisions and CPU seconds when the curve first stood at `share`."""
        return next(((at, cpu) for at, cpu, rate in self.curve if rate >= share), None)


def practise(variant: str, seed: int, most: int, fields: int) -> Practised:
    """Learn, and look how well it does at every doubling of what was practised."""
    view, calm, decisions = VARIANTS[variant]
    decisions = min(decisions, most)
    scene = scene_at(SHOWN_AT)
    settings = PPO(decisions=decisions, calm=calm, seed=seed)
    curve: list[tuple[int, float, float]] = []

    def watch(lesson: Lesson) -> None:
        if lesson.decisions >= min(8_192 * 2 ** len(curve), decisions):
            policy = Policy(
                lesson.network,
                scene.identity(),
                view,
                scene.perception(view).state,
                scene.action,
                0,
                "",
            )
            tried = fly(scene, PolicyPilot(policy), CURVE_FIELDS, min(fields, 100))
            curve.append((lesson.decisions, lesson.cpu_s, tried.crossed / tried.fields))
            print(variant, seed, *curve[-1], f"turn {tried.turn:.3f}", flush=True)

    policy = settings.learn(scene, view, watch=watch)
    return Practised(variant, seed, curve, policy, fly(scene, PolicyPilot(policy), FIELDS, fields))


def draw(runs: Sequence[Practised], path: Path) -> None:
    """The learning curves."""
    figure, axes = pyplot.subplots(1, 2, figsize=(9.0, 3.4), sharey=True, layout="constrained")
    colors = dict(zip(VARIANTS, ("#1f77b4", "#2ca02c", "#d62728"), strict=True))
    for run in runs:
        decisions, cpu, rate = (np.array(column) for column in zip(*run.curve, strict=True))
        first = run.seed == runs[0].seed
        for axis, across in zip(axes, (decisions, cpu), strict=True):
            axis.plot(
                across,
                100 * rate,
                marker=".",
                color=colors[run.variant],
                label=run.variant if first else None,
            )
    for axis, label in zip(axes, ("decisions practised", "CPU s"), strict=True):
        axis.set_xscale("log")
        axis.set_xlabel(label)
        axis.axhline(90, color="0.7", linewidth=0.8)
        axis.set_ylim(0, 101)
    axes[0].set_ylabel(f"unseen fields crossed at NH {SHOWN_AT:g}, %")
    axes[0].legend(fontsize=8, loc="lower right", bbox_to_anchor=(1.0, 0.56))
    figure.savefig(path, metadata={"Date": None})
    pyplot.close(figure)


# -- by tables -----------------------------------------------------------------------------------


@dataclass(frozen=True)
class Tabled:
    """One table as it was learned."""

    view: str
    divisions: int
    cells: int
    seen: float
    """Share of the cells."""
    stored_mb: float
    cpu_s: float
    pace: float
    """Decisions practised a CPU second."""
    result: Crossed


def tabulate(view: str, divisions: int, seed: int, decisions: int, fields: int) -> Tabled:
    """Learn one table and fly by it."""
    scene = scene_at(SHOWN_AT)
    began = time.process_time()
    learned = learn_table(scene, view, divisions, steps=decisions, seed=seed, discount=DISCOUNT)
    spent = time.process_time() - began
    cells = learned.pilot.grid.cells
    result = fly(scene, learned.pilot, FIELDS, fields)
    print(view, divisions, seed, result, f"{spent:.0f} s", flush=True)
    seen, stored = learned.cells_seen / cells, learned.stored_bytes / 1e6
    return Tabled(view, divisions, cells, seen, stored, spent, decisions / spent, result)


def about_table(tables: Sequence[Tabled]) -> str:
    """The row of one grid, from its seeds."""
    one = tables[0]
    rates = [100 * table.result.crossed / table.result.fields for table in tables]
    times = [table.result.steps / 15 for table in tables if table.result.crossed]
    return (
        f"| `{one.view}` | {one.divisions} | {one.cells:,} "
        f"| {middle([100 * table.seen for table in tables], '{:.1f}')} "
        f"| {statistics.median(table.stored_mb for table in tables):.1f} "
        f"| {statistics.median(table.cpu_s for table in tables):.0f} "
        f"| {middle(rates, '{:.1f}')} | {middle(times, '{:.0f}') if times else ''} "
        f"| {middle([100 * table.result.turn for table in tables], '{:.0f}')} |"
    )


# -- cloning by `imitation` ------------------------------------------------------------------------


def clone(interpreter: Path, style: str, seed: int, fields: int) -> tuple[str, Layers]:
    """A row and the pilot: cloned by `imitation` from 8 minutes of the scripted `style`."""
    scene = scene_at(SHOWN_AT)
    pairs = demonstrate(scene, find_pilot(f"scripted:{style}"), seed, 8.0)["canonical"]
    offset, scale = pairs.states.mean(axis=0), pairs.states.std(axis=0)
    with tempfile.TemporaryDirectory() as folder:
        given, made = Path(folder) / "pairs.npz", Path(folder) / "network.npz"
        np.savez(
            given, states=(pairs.states - offset) / scale, actions=pairs.actions / scene.action.high
        )
        script = str(ROOT / "benchmarks" / "imitation_bc.py")
        subprocess.run([str(interpreter), script, str(given), str(made)], check=True)
        with np.load(made) as network:
            arrays = dict(network)
    spent = float(arrays.pop("cpu_s"))
    pilot = Layers("canonical", {"offset": offset, "scale": scale, **arrays})
    result = fly(scene, pilot, FIELDS, fields)
    print(style, seed, result, flush=True)
    return f"| {style}, seed {seed} | {spent:.0f} | {result.told} |", pilot


# -- all of it -----------------------------------------------------------------------------------


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="little of everything")
    parser.add_argument("--only", choices=PARTS, help="one part alone")
    parser.add_argument("--seeds", type=int, default=1, help="runs of each variant of PPO")
    parser.add_argument("--fields", type=int, default=0, help="fields that each pilot flies")
    parser.add_argument("--jobs", type=int, default=min(2, os.cpu_count() or 1))
    parser.add_argument("--imitation", type=Path, help="a Python that has the library imitation")
    options = parser.parse_args()
    most = 20_000 if options.quick else 10**9
    fields = options.fields or (20 if options.quick else 1000)
    parallel = joblib.Parallel(n_jobs=options.jobs)
    for part in (options.only,) if options.only else PARTS:
        at = commit("evastudio/world", "evastudio/pilots", "scenes", "benchmarks/rl.py")
        began = time.monotonic()
        match part:
            case "ppo":
                runs = parallel(
                    joblib.delayed(practise)(variant, seed, most, fields)
                    for seed in range(1, options.seeds + 1)
                    for variant in reversed(VARIANTS)
                )
                if not options.quick:
                    keep(runs)
                lines = about_ppo(runs)
            case "tables":
                cut = [
                    (view, many, seed)
                    for view, each in TABLES
                    for many in each
                    for seed in TABLE_SEEDS
                ]
                decisions = min(TABLED, most)
                lines = about_tables(
                    parallel(joblib.delayed(tabulate)(*one, decisions, fields) for one in cut),
                    decisions,
                )
            case _:
                if options.imitation is None:
                    continue
                asked = [(style, seed) for style in ("careful", "human") for seed in SETS[:2]]
                cloned = parallel(
                    joblib.delayed(clone)(options.imitation, *one, fields) for one in asked
                )
                if not options.quick:
                    _, pilot = cloned[asked.index(("human", SETS[0]))]
                    pilot.save(TRAINED / "asteroids-imitation.npz")
                lines = about_imitation([row for row, _ in cloned])
        words = ["PYTHON" if word == str(options.imitation) else word for word in sys.argv[1:]]
        command = " ".join(["python -m benchmarks.rl", *words])
        when = where_and_when(at, command, time.monotonic() - began)
        text = "\n".join((lines[0], "", when, *lines[1:])).replace("@fields", f"{fields:,}")
        print(text)
        if not options.quick:
            write_section(ROOT / "docs" / "baselines.md", f"reinforcement learning: {part}", text)


def keep(runs: Sequence[Practised]) -> None:
    """Draw the curves, and store the policies of the first seed."""
    draw(runs, ROOT / "docs" / "rl.svg")
    for run in runs:
        if run.seed == 1:
            view, calm, _ = VARIANTS[run.variant]
            name = f"asteroids-ppo-{view}{'-calm' if calm else ''}.safetensors"
            made = replace(run.policy, made_by="python -m benchmarks.rl --only ppo")
            save_policy(made, TRAINED / name)


def about_ppo(runs: Sequence[Practised]) -> list[str]:
    """The section on PPO, in Markdown."""
    lines = [
        "## Reinforcement learning by networks: PPO",
        "- Written by `make bench-rl`; do not edit by hand.",
        f"- Asteroid field at NH {SHOWN_AT:g}, corridor 100 m to either side. Crossed: of @fields "
        f"unseen fields (seed {FIELDS}, those of `docs/results.md`), with Wilson's 95 % interval. "
        f"Curves: 100 other fields (seed {CURVE_FIELDS}).",
        "- Reward: that of the scene's Gymnasium environment, the gain in progress, +1 for "
        "crossing and -1 for any other end. Where turning costs, each decision also costs 0.002 "
        "times the squared action, its components as shares of the largest turn (progress earns "
        "at most 0.0019 a decision).",
        "- Stable-Baselines3 (`evastudio.pilots.ppo.PPO` at its defaults): 128 worlds at a time, a "
        "policy of one layer of 32 tanh units, a critic of two of 64, discount 0.99, learning rate "
        "0.0005. Tuning, on 200 fields of seed 777: two settings (the other: two layers of 64, ten "
        "epochs, rate 0.0003, which learned as fast), one cost of turning; nothing was tuned "
        "under `paper`, where two layers of 64 crossed 55 % after a million decisions.",
        "- The policies of seed 1 are in `benchmarks/trained/`; they play without PyTorch. CPU "
        "time is practice and learning on one core, without the flights for the curve.",
        "",
        "![Learning curves](rl.svg)",
        "",
        "| perception, reward | seed | decisions to 90 % | CPU s to 90 % | decisions | CPU s "
        "| crossed, % | time to cross, s | turn, % |",
        "|---|---:|---:|---:|---:|---:|---:|---:|---:|",
    ]
    for run in sorted(runs, key=lambda one: (list(VARIANTS).index(one.variant), one.seed)):
        reached = run.reached(0.9)
        first = f"{reached[0]:,} | {reached[1]:.0f}" if reached else "not reached | "
        decisions, spent, _ = run.curve[-1]
        lines.append(
            f"| {run.variant} | {run.seed} | {first} | {decisions:,} | {spent:.0f} "
            f"| {run.result.told} |"
        )
    return lines


def about_tables(tables: Sequence[Tabled], decisions: int) -> list[str]:
    """The section on tables, in Markdown."""
    cells, values, pairs = table_bytes(9, 10, 9)
    _, less, fewer = table_bytes(8, 10, 9)
    pace = statistics.median(table.pace for table in tables)
    each = len(TABLE_SEEDS)
    days = cells * 9 / pace / 86_400
    return [
        "## Reinforcement learning by tables",
        f"- At the paper's size, 9 dimensions of 10 divisions: {cells:,} cells; their values V "
        f"take {values / 1e9:.0f} GB (the paper says about 8 G), Q for 9 actions "
        f"{pairs / 1e9:.0f} GB. To try every action once in every cell would take {days:.1f} days "
        f"of CPU time at the {pace:,.0f} decisions a second of the runs below (the paper says "
        f"about a week). The paper lists 8 inputs and counts 9; 8 would take {less / 1e9:.1f} GB "
        f"and {fewer / 1e9:.1f} GB, and {days / 10:.1f} days.",
        f"- Coarse grids that fit, {decisions:,} decisions of practice each at NH {SHOWN_AT:g}: "
        "value iteration over the transitions counted (`evastudio.pilots.table`), nine actions "
        f"(each component lowest, at rest or highest), discount {DISCOUNT:g}, cut so that equally "
        "many states of straight and of random flight lie in each part. Tuning: four discounts "
        "at 3 divisions, on 100 fields of seed 777.",
        f"- Crossed: of @fields unseen fields (seed {FIELDS}). Median of {each} runs, and their "
        "range.",
        "",
        "| perception | divisions | cells | seen, % | stored, MB | CPU s | crossed, % "
        "| time to cross, s | turn, % |",
        "|---|---:|---:|---:|---:|---:|---:|---:|---:|",
        *(about_table(tables[at : at + each]) for at in range(0, len(tables), each)),
    ]


def about_imitation(rows: Sequence[str]) -> list[str]:
    """The section on the library imitation, in Markdown."""
    return [
        "## Behaviour cloning by `imitation`",
        "- The library's behaviour cloning at its defaults (two layers of 32 tanh units), from 8 "
        "minutes of a scripted demonstrator under `canonical`, states standardised; the number of "
        "epochs, up to 30, is chosen by a tenth of the pairs held out.",
        "- The library (1.0.1) wants gymnasium 0.29 and Stable-Baselines3 2.2, and the studio "
        "gymnasium 1: pip refuses the two together, so it is no extra of the studio's but runs in "
        "an environment of its own.",
        f"- Crossed: of @fields unseen fields at NH {SHOWN_AT:g} (seed {FIELDS}). The one cloned "
        f"from the scripted human of seed {SETS[0]} is in `docs/results.md` beside all others.",
        "",
        "| demonstration | CPU s | crossed, % | time to cross, s | turn, % |",
        "|---|---:|---:|---:|---:|",
        *rows,
    ]


if __name__ == "__main__":
    main()
