"""What `benchmarks/reproduction.py` found, as tables and a figure."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import matplotlib as mpl
import numpy as np

from benchmarks.crossing import FIELDS, middle
from benchmarks.plain_state import (
    BEST,
    DEMONSTRATORS,
    DENSITIES,
    FACTORS,
    PLAIN,
    RAW,
    STATES,
    Cell,
    Found,
)
from evastudio.evaluation.interval import wilson_interval

mpl.use("svg")
mpl.rcParams["svg.hashsalt"] = "evastudio"
from matplotlib import pyplot  # noqa: E402 - after the choice of how to draw

SETS = (9001, 9002, 9003)
TUNING_SET, TUNING_FIELDS = 1, 777
TUNED_ON = 24
"""Fields that each setting is tried in."""


class Atlas:
    """What was found, by cell."""

    def __init__(self, found: Mapping[Cell, Found]) -> None:
        self.found = found

    def of(self, cell: Cell) -> Found:
        """A cell's, or that of the same flown in more densities."""
        return self.found.get(cell) or self.found[replace(cell, flown_at=DENSITIES)]

    def rate(self, cell: Cell, density: float = 4.0) -> str:
        rates = [100 * one.success_rate for one in self.of(cell).policies[density]]
        return middle(rates, "{:.0f}")

    def ends(self, cell: Cell, density: float = 4.0) -> str:
        """Mean share of fields that ended by a hit, and outside."""
        flights = self.of(cell).policies[density]
        names = flights[0].endings
        shares = [
            np.mean([(one.outcomes == names.index(end)).mean() for one in flights])
            for end in ("hit", "left")
        ]
        return " / ".join(f"{100 * share:.0f}" for share in shares)


def report(atlas: Atlas, sets: Sequence[int], fields: int, line: str) -> str:
    low, high = wilson_interval(fields // 2, fields)
    lines = [
        "## The figures",
        "",
        "Written by `make bench-reproduction`; do not edit by hand.",
        "",
        line,
        "- **The demonstrators are programs, no person flew.** `careful` answers to all that "
        "presses on the ship from ahead; `two nearest` is a function of the paper's state and "
        "of nothing else; its `human hand` is late, trembles and errs.",
        f"- Fields crossed, %: median of {len(sets)} demonstration sets (seeds "
        f"{', '.join(map(str, sets))}) and their range, each policy in the same {fields} unseen "
        f"fields (seed {FIELDS}). One policy that crosses half of them has a 95 % interval of "
        f"{100 * low:.0f} to {100 * high:.0f} %.",
        "- The setting of each cell (k-NN: k 1, 3 or 7; SVR: gamma .01, .03, .1 or .3, C 30, "
        f"epsilon .1) was chosen on another set (seed {TUNING_SET}) and {TUNED_ON} other fields "
        f"(seed {TUNING_FIELDS}).",
        "- Hit / left: the share that ended at a rock, and outside the corridor, at NH 4.",
        "",
        "### Who demonstrates",
        "",
        "Shown at NH 4, 6,000 pairs where nothing else is said, the paper's state.",
        "",
        "| pilot | " + " | ".join(f"NH {at:g}" for at in DENSITIES) + " | hit / left | setting |",
        "|---|" + "---:|" * (len(DENSITIES) + 1) + "---|",
    ]
    straight = Cell("straight", "itself", flown_at=DENSITIES)
    rows = [("straight flight", straight)]
    for who in DEMONSTRATORS:
        rows.append((f"{who}: the demonstrator", Cell(who, "itself", flown_at=DENSITIES)))
        rows += [(f"{who}: {learner}", Cell(who, learner, flown_at=DENSITIES)) for learner in PLAIN]
    best = "two nearest, 24,000 pairs shown at NH 8"
    rows += [(f"{best}: {learner}", replace(BEST, learner=learner)) for learner in PLAIN]
    for name, cell in rows:
        cells = [atlas.rate(cell, at) for at in DENSITIES]
        told = " | ".join([name, *cells, atlas.ends(cell), atlas.of(cell).setting])
        lines.append(f"| {told} |")
    lines += [
        "",
        "### What field, how fast, how many pairs",
        "",
        "One thing changed at a time, `two nearest` demonstrates, flown at NH 4 (rocks are fewer "
        "where they are larger).",
        "",
        "| what | the demonstrator | knn | hit / left | svr | hit / left | settings |",
        "|---|---:|---:|---:|---:|---:|---|",
    ]
    for name, cell in FACTORS.items():
        own = Cell(learner="itself", flown_at=DENSITIES)
        own = replace(cell, learner="itself") if cell.constants else own
        told = [name, atlas.rate(own)]
        for learner in PLAIN:
            with_it = replace(cell, learner=learner)
            told += [atlas.rate(with_it), atlas.ends(with_it)]
        told.append(", ".join(atlas.of(replace(cell, learner=how)).setting for how in PLAIN))
        lines.append(f"| {' | '.join(told)} |")
    lines += [
        "",
        "### States as they are",
        "",
        "Otherwise as in the first row above; there, states are standardised. Gamma: .001 or .003.",
        "",
        "| learner, unit of the angles | crossed | hit / left | setting |",
        "|---|---:|---:|---|",
    ]
    for learner in RAW:
        cell = Cell(learner=learner)
        lines.append(
            f"| {learner} | {atlas.rate(cell)} | {atlas.ends(cell)} | {atlas.of(cell).setting} |"
        )
    lines += [
        "",
        "### What else could be seen",
        "",
        "The two rocks as seen from the ship (own frame), as directions that fade with distance "
        "(fading), the nearest not behind (ahead); the orientation stays. Flown at NH 4.",
        "",
        "| state | " + " | ".join(f"{who}: {how}" for who in STATES for how in PLAIN) + " |",
        "|---|---:|---:|---:|---:|",
    ]
    for state in STATES["careful"]:
        rates = [
            atlas.rate(Cell(who, learner, state)) if state in states else ""
            for who, states in STATES.items()
            for learner in PLAIN
        ]
        lines.append(f"| {state} | {' | '.join(rates)} |")
    return "\n".join(lines)


def draw(atlas: Atlas, path: Path) -> None:
    """Crossing over NH, by demonstrator; the sets' range is shaded."""
    figure, plots = pyplot.subplots(1, 3, figsize=(9.0, 3.0), sharey=True, layout="constrained")
    styles = (("itself", "#777777", "demonstrator"), ("knn", "#d95f02", "k-NN"))
    styles += (("svr", "#1b6ca8", "SVR"),)
    for plot, who in zip(plots, DEMONSTRATORS, strict=True):
        for learner, color, label in styles:
            flights = atlas.of(Cell(who, learner, flown_at=DENSITIES)).policies
            rates = np.array([[100 * one.success_rate for one in flights[at]] for at in DENSITIES])
            plot.plot(DENSITIES, np.median(rates, axis=1), "o-", color=color, label=label, ms=3)
            plot.fill_between(
                DENSITIES, rates.min(axis=1), rates.max(axis=1), color=color, alpha=0.2, lw=0
            )
        alone = atlas.of(Cell("straight", "itself", flown_at=DENSITIES)).policies
        rates = np.array([100 * alone[at][0].success_rate for at in DENSITIES])
        plot.plot(DENSITIES, rates, ":", color="black", label="straight flight")
        plot.set(title=who, xlabel="NH", xscale="log", xticks=DENSITIES, ylim=(-3, 103))
        plot.set_xticks(DENSITIES, [f"{at:g}" for at in DENSITIES])
        plot.minorticks_off()
    plots[0].set_ylabel("fields crossed, %")
    plots[0].legend(frameon=False, fontsize=8, loc="center right", bbox_to_anchor=(1.0, 0.66))
    figure.savefig(path, metadata={"Date": None})
    pyplot.close(figure)
