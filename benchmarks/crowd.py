"""Does a crowd of one learned policy walk without getting in its own way? Writes docs/crowd.md.

    python -m benchmarks.crowd            # some 10 minutes
    python -m benchmarks.crowd --quick    # two worlds, one minute, to see that it runs

200 people on 40 x 40 cells, ten minutes, five worlds; policies that learned from the lead among
people who stand still; other densities; how the boulder is fled; and, into docs/performance.md,
how fast a crowd decides. All demonstrators are programs.
"""

from __future__ import annotations

import argparse
import statistics
import sys
import tempfile
import time
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from scipy.stats import t as student

from benchmarks.crowds.fleeing import AT_ONCE_S, AWAY, FAST, NEAR, PAIRS, Fled
from benchmarks.crowds.rows import (
    DENSITIES,
    FEWER_MINUTES,
    LEARNED_MINUTES,
    MINUTES,
    PEOPLE,
    SHOWN,
    SIDE,
    STYLES,
    WORLDS,
    Row,
    flee_all,
    shipped,
    walk_all,
)
from benchmarks.crowds.speed import draw, measure, told
from benchmarks.report import ROOT, commit, where_and_when, write_section
from evastudio.learning.compiled import ensure_compiled

BLOCKED, GUARDED, STUCK_S, VARIETY = 8.0, 4.0, 10.0, 0.2
"""What is allowed: blocked steps a minute without and with the guard, stuck, variety off."""


def span(values: Sequence[float], form: str = "{:.1f}") -> str:
    """Mean and range."""
    low, mean, high = (form.format(f(values)) for f in (min, statistics.fmean, max))
    return mean if low == high else f"{mean} ({low} to {high})"


def interval(values: Sequence[float]) -> tuple[float, float]:
    """The mean of values of independent worlds, and half its 95 % interval (Student's t)."""
    half = student.ppf(0.975, max(1, len(values) - 1)) * np.std(values, ddof=1) / len(values) ** 0.5
    return float(np.mean(values)), float(half)


class Tables:
    """The figures, in Markdown."""

    def __init__(self, rows: Sequence[Row]) -> None:
        self.rows = {(row.name, row.guard, row.people): row for row in rows}

    def variety(self, row: Row, style: str) -> float:
        """How far the cells visited are from the demonstrator's in the same worlds, a share."""
        own = self.rows[f"scripted:{style}", False, row.people].of("cells")
        return float(row.of("cells").mean() / own.mean() - 1.0)

    def line(self, row: Row, style: str) -> str:
        """One row of a table of crowds."""
        cells = [
            row.name.removeprefix(f"{style}: "),
            "yes" if row.guard else "",
            span(row.of("blocked"), "{:.2f}"),
            span(row.of("helped"), "{:.2f}"),
            f"{row.of('stuck_s').max():.1f}",
            f"{row.of('still_s').max():.1f}",
            span(row.of("cells")),
            f"{100 * self.variety(row, style):+.0f} %",
            "yes" if self.good(row, style) else "no",
        ]
        return f"| {' | '.join(cells)} |"

    def good(self, row: Row, style: str) -> bool:
        """Whether a crowd keeps to what is allowed."""
        return bool(
            row.of("blocked").mean() <= (GUARDED if row.guard else BLOCKED)
            and row.of("stuck_s").max() < STUCK_S
            and abs(self.variety(row, style)) <= VARIETY
        )

    def crowds(self, rows: Sequence[Row], style: str) -> list[str]:
        """A table of crowds that walk as `style`."""
        return [
            "| pilot | guard | blocked a minute | guard helped a minute | longest stuck, s "
            "| longest in a cell, s | cells a minute | of the demonstrator's | within the bars |",
            "|---|---|---:|---:|---:|---:|---:|---:|---|",
            *(self.line(row, style) for row in rows),
        ]

    def densities(self) -> list[str]:
        """Shipped policies beside their demonstrators, from sparse to dense."""
        lines = [
            "| taken cells | pilot | guard | blocked a minute | longest stuck, s | cells a minute "
            "| of the demonstrator's |",
            "|---:|---|---|---:|---:|---:|---:|",
        ]
        for share, people in DENSITIES.items():
            for style in STYLES:
                for name, guard in (
                    (f"scripted:{style}", False),
                    (f"crowd-{style}", False),
                    (f"crowd-{style}", True),
                ):
                    row = self.rows[name, guard, people]
                    cells = [
                        f"{share:g} %",
                        name,
                        "yes" if guard else "",
                        span(row.of("blocked"), "{:.2f}"),
                        f"{row.of('stuck_s').max():.1f}",
                        span(row.of("cells")),
                        f"{100 * self.variety(row, style):+.0f} %",
                    ]
                    lines.append(f"| {' | '.join(cells)} |")
        return lines

    def styles(self) -> list[str]:
        """What tells the two styles apart."""
        names = [f"{kind}{style}" for kind in ("scripted:", "crowd-") for style in STYLES]
        lines = [
            f"| | {' | '.join(names)} | apart |",
            "|---|---:|---:|---:|---:|---|",
        ]
        for label, field, scale in (
            ("decisions to stand, %", "standing", 100.0),
            ("decisions to turn, %", "turning", 100.0),
            ("free cells ahead of those who walk", "room", 1.0),
            ("cells a minute", "cells", 1.0),
        ):
            found = [interval(scale * self.rows[name, False, PEOPLE].of(field)) for name in names]
            gaps = [
                abs(found[at][0] - found[at + 1][0]) - found[at][1] - found[at + 1][1]
                for at in (0, 2)
            ]
            cells = [f"{mean:.2f} ± {half:.2f}" for mean, half in found]
            apart = "yes" if min(gaps) > 0.0 else "no"
            lines.append(f"| {label} | {' | '.join(cells)} | {apart} |")
        return lines


def boulder(fled: Mapping[str, Sequence[Fled]]) -> list[str]:
    """How the boulder was fled."""
    lines = [
        "| learned by | near the impact | knocked over | flee in time | error then, degrees "
        "| error from then on, degrees |",
        "|---|---:|---:|---:|---:|---:|",
    ]
    for name, ones in fled.items():
        cells = [
            name,
            str(sum(one.near for one in ones)),
            str(sum(one.hit for one in ones)),
            span([100 * one.fled for one in ones], "{:.1f} %"),
            span([one.first_deg for one in ones]),
            span([one.later_deg for one in ones]),
        ]
        lines.append(f"| {' | '.join(cells)} |")
    return lines


def report(rows: Sequence[Row], fled: Mapping[str, Sequence[Fled]], opening: str) -> str:
    """The section on how crowds walk and run."""
    tables = Tables(rows)
    plain = [row for row in rows if row.people == PEOPLE]
    lines = [
        "# The crowd, measured",
        "",
        "Written by `make bench-crowd`; do not edit by hand.",
        "",
        opening,
        f"- **All demonstrators are programs.** {PEOPLE} people on {SIDE} x {SIDE} cells "
        f"({100 * PEOPLE / SIDE**2:g} %), {MINUTES:g} simulated minutes, worlds "
        f"{', '.join(map(str, WORLDS))}. Mean over the worlds, with the range; longest times over "
        "all.",
        "- Blocked: somebody walks into a cell that is taken, or that somebody else gets. With the "
        "guard nobody is: it counts how often it chose instead.",
        "- Stuck: from wanting to walk on, and not getting to, until leaving the cell, whatever is "
        "done in between; at most 10 s are allowed. Longest in a cell: also without wanting to, "
        "but for decisions to stand, which are chosen rests.",
        "- Cells: different ones that somebody stands in within a minute, beside those of the "
        "scripted demonstrator, without a guard, in the same worlds (20 % off are allowed).",
        "",
        "## Shipped policies",
        "",
    ]
    for style in STYLES:
        named = (f"scripted:{style}", f"crowd-{style}")
        lines += [*tables.crowds([row for row in plain if row.name in named], style), ""]
    lines += [
        "## Perceptions and ways to learn",
        "",
        f"Each world is walked by policies from a demonstration of its own: {SHOWN:g} minutes of "
        f"`scripted:{STYLES[0]}`, who leads among people who stand still, as `record` does it; "
        f"{LEARNED_MINUTES:g} minutes in each world.",
        "",
        *tables.crowds([row for row in plain if row.name.startswith(STYLES[0])], STYLES[0]),
        "",
        "## From sparse to dense",
        "",
        f"{FEWER_MINUTES:g} minutes where it is not {100 * PEOPLE / SIDE**2:g} %.",
        "",
        *tables.densities(),
        "",
        "## Two styles",
        "",
        "Mean and 95 % interval over the worlds; apart where the intervals of the two styles do "
        "not meet, for the demonstrators and for the policies.",
        "",
        *tables.styles(),
        "",
        "## After the boulder",
        "",
        f"From the first {PAIRS} pairs of `scripted:startled`, a demonstration for each "
        f"world, recorded as `record` does it. Counted are those nearer than {NEAR:g} m to "
        f"the impact, {AT_ONCE_S:g} s after it, who was knocked over that long after being "
        f"up. To flee is to run {FAST:g} m/s or more, within {np.degrees(AWAY):.0f} "
        "degrees of straight away, and to go on.",
        "",
        *boulder(fled),
    ]
    return "\n".join(lines)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="two worlds, one minute")
    parser.add_argument("--only", choices=("walk", "speed"), help="one of the two sections")
    parser.add_argument("--jobs", type=int, default=2)
    options = parser.parse_args()
    quick = options.quick
    docs = Path(tempfile.mkdtemp()) if quick else ROOT / "docs"
    ensure_compiled()
    at = commit("evastudio", "scenes", "policies", "benchmarks")
    command = f"python -m benchmarks.crowd {' '.join(sys.argv[1:])}".strip()
    if options.only != "walk":
        began = time.monotonic()
        ticks, views = measure(shipped("crowd-hurried"), quick)
        draw(ticks, docs / "crowd.svg")
        opening = where_and_when(at, command, time.monotonic() - began)
        text = "\n".join(told(ticks, views, opening))
        print(text, flush=True)
        write_section(docs / "performance.md", "crowd", text)
    if options.only != "speed":
        began = time.monotonic()
        seeds = WORLDS[:2] if quick else WORLDS
        rows = walk_all(seeds, quick, options.jobs)
        fled = flee_all(seeds, options.jobs)
        opening = where_and_when(at, command, time.monotonic() - began)
        text = report(rows, fled, opening)
        print(text)
        write_section(docs / "crowd.md", "crowd", text)


if __name__ == "__main__":
    main()
