"""The paper's tables with what was measured here beside, as rows, Markdown and JSON."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from evastudio.evaluation.interval import Interval, mean_interval
from evastudio.evaluation.paper import ASTAR, COMPACT, KNN, SVM, Measured
from evastudio.evaluation.preferences import Preference
from evastudio.evaluation.studies import Study
from evastudio.evaluation.table_three import table_three
from evastudio.pilots.astar import AStarPilot
from evastudio.pilots.table import table_bytes

MINUTE, HOUR, WEEK = 60.0, 3600.0, 7 * 24 * 3600.0
DIMENSIONS, DIVISIONS, ACTIONS = 9, 10, 9
"""Of the paper's table for reinforcement learning; it does not say how many actions."""
UNITS: Mapping[str, Sequence[tuple[float, str]]] = {
    "s": (
        (24 * HOUR, "days"),
        (HOUR, "h"),
        (MINUTE, "min"),
        (1.0, "s"),
        (1e-3, "ms"),
        (1e-6, "us"),
    ),
    "B": ((1e9, "GB"), (1e6, "MB"), (1e3, "KB"), (1.0, "B")),
    "%": ((1.0, "%"),),
    "": ((1.0, ""),),
}
"""Of seconds, bytes, shares and counts, the largest first."""


@dataclass(frozen=True)
class Row:
    """One line of a table."""

    group: str
    what: str
    unit: str
    """One of UNITS."""
    paper: float | None
    """None where the paper has no such line."""
    here: float | None
    """None where it was not measured; `note` says why."""
    interval: Interval | None = None
    """95 %, of `here`."""
    note: str = ""


def table_one(found: Measured) -> list[Row]:
    """The paper's table 1: demonstrating, cleaning, k-nn and SVM."""
    cleaned = found.cleaned
    rows = [
        Row("Pairs", "Number of state-action pairs", "", 6000, found.pairs),
        Row(
            *("Pairs", "Time to demonstrate all pairs", "s", 8 * MINUTE, found.demonstrated_s),
            note="flown by a program, without a pause",
        ),
        Row(
            *("Pairs", "Time to eliminate conflicts", "s", 16.0, cleaned.seconds),
            note=f"limits found from the pairs: {cleaned.cut:,} left out",
        ),
        Row(
            *("Pairs", "the same by the paper's l = 5 and 0.1", "s", None, cleaned.paper_s),
            note=f"would leave out {cleaned.paper_cut:,}; not used",
        ),
    ]
    theirs = {
        KNN: (13e-6, 1e6, 7.04e-3, 36.1),
        SVM: (2e-6, 10e3, 1.13e-3, 37.7),
        COMPACT: (2e-6, 10e3, 1.13e-3, 37.7),
    }
    for name, paper in theirs.items():
        if name != KNN:
            made_s = found.costs[name].made_s
            rows.append(Row(name, "Time to train", "s", 2.5 * MINUTE, made_s))
        rows += _policy(found, name, "Compute target function values", *paper)
    return rows


def table_two(found: Measured) -> list[Row]:
    """The paper's table 2: reinforcement learning, PEGASUS and A*."""
    cells, values, choices = table_bytes(DIMENSIONS, DIVISIONS, ACTIONS)
    visits_s = cells * ACTIONS * found.step_s
    rows = [
        Row(
            *("RL", "Storage requirements", "B", 8e9, values),
            note=f"arithmetic: {DIVISIONS}^{DIMENSIONS} cells of 8 bytes; {choices / 1e9:.0f} GB "
            f"where each of {ACTIONS} actions has a value",
        ),
        Row(
            *("RL", "Time to learn policy", "s", WEEK, None),
            note="not measured; smaller tables, and networks (PPO), are in docs/baselines.md",
        ),
        Row(
            *("RL", "to see every cell and action once", "s", None, visits_s),
            note=f"arithmetic: {found.step_s * 1e6:.1f} us CPU a step of the field was measured",
        ),
    ]
    for name, search in found.searches.items():
        last = search.rounds[-1]
        rows.append(
            Row(
                *(name, "Time to learn policy", "s", 2.3 * HOUR, found.costs[name].made_s),
                note=f"{last.trials:,} networks tried, {last.decisions:,} decisions",
            )
        )
        rows += _policy(found, name, "Time to select actions", 2e-3, 5e3, 6.95, 36.6)
    plans = [plan for one in found.crossings[ASTAR] for plan in one.plans]
    held = [held for _, held in plans]
    rows += [
        Row(ASTAR, "Average storage requirement", "B", 8e6, float(np.mean(held))),
        Row(ASTAR, "Max storage requirement", "B", 370e6, float(max(held))),
        Row(
            *(ASTAR, "Time to select actions", "s", 0.2, _deciding_s(found, ASTAR)),
            note=f"a search every {AStarPilot().every} decisions, of "
            f"{np.mean([nodes for nodes, _ in plans]):.0f} nodes on average",
        ),
        _total(found, ASTAR, 104.1),
        *_crossed(found, ASTAR, 34.7),
    ]
    return rows


def to_markdown(
    found: Measured, studies: Sequence[Study], preferences: Sequence[Preference], made: str
) -> str:
    """All three tables, with the settings that they were made by; `made` says where and when."""
    extent = found.extent
    settings = "; ".join(
        f"{name}: {', '.join(f'{key} {value}' for key, value in own.items())}"
        for name, own in found.settings.items()
    )
    searches = "; ".join(
        f"{one.optimiser}: {one.rounds} rounds of {one.population} networks of {one.hidden} units, "
        f"{one.scenarios} fields of {one.horizon_s:g} s, seed {one.seed}"
        for one in extent.searches
    )
    pilot = AStarPilot()
    return "\n".join(
        [
            "# The paper's tables, measured here",
            "",
            f"- {made}",
            f"- **No person flew.** The demonstrator is a program, the scripted `human`: "
            f"{found.pairs:,} pairs at NH {extent.at:g} (NH: expected hits of a straight flight), "
            f"corridor {extent.half_width_m:g} m to either side, seed {extent.seed}. Perception "
            "`canonical`; with the paper's plain state hardly a field is crossed "
            "(docs/results.md).",
            f"- Flown through {extent.worlds} new fields at each NH "
            f"({', '.join(f'{density:g}' for density in extent.densities)}; seed "
            f"{extent.fields_seed}), the same for all; {extent.timed} of them at NH {extent.at:g} "
            "alone, with a clock at each decision. Times are CPU times of one process, medians "
            f"of {extent.repeats} where they repeat; the machine is shared, so read them to one "
            "digit. In brackets: 95 % intervals (Wilson, bootstrap).",
            f"- Learners: {settings}. PEGASUS: {searches}. A*: {pilot.nodes} nodes a search, "
            f"primitives of {pilot.hold} decisions, sight {pilot.sight_m:g} m; it searches the "
            "true field.",
            "- The paper's machine had a processor of 1.7 GHz and 512 MB; the ratio of times says "
            "as much about machines as about programs. Its field, its number of asteroids and its "
            "k (2 to 7) are not told closer.",
            "",
            "## Table 1: demonstration, k-NN and SVM",
            "",
            *_table(table_one(found)),
            "",
            "The paper's total is its time of one target function value, times the frames of a "
            "crossing; the first of ours is made alike, the second is what all decisions took, "
            "what they perceive included.",
            "",
            "## Table 2: reinforcement learning, PEGASUS and A*",
            "",
            *_table(table_two(found)),
            "",
            "The paper's 6.95 s for PEGASUS are not its 2 ms times the 549 frames of 36.6 s, which "
            "would be 1.1 s; it does not say what else is in them.",
            "",
            "## Table 3: people",
            "",
            *table_three(studies, preferences),
            "",
        ]
    )


def to_json(
    found: Measured, studies: Sequence[Study], preferences: Sequence[Preference]
) -> dict[str, Any]:
    """The same as JSON holds it, with every pilot's figures by density."""
    return {
        "tables": {
            "1": [asdict(row) for row in table_one(found)],
            "2": [asdict(row) for row in table_two(found)],
            "3": [asdict(one) for one in studies],
        },
        "preferences": [
            {**asdict(one), "share": one.share, "interval": one.interval} for one in preferences
        ],
        "extent": asdict(found.extent),
        "demonstrator": "scripted:human",
        "settings": {name: dict(own) for name, own in found.settings.items()},
        "densities": [
            {
                "density": density,
                "pilots": {name: one.to_json() for name, one in compared.pilots.items()},
            }
            for density, compared in found.compared.items()
        ],
    }


def quantity(value: float | None, unit: str) -> str:
    """`value` in the largest of its units that leaves it 1 or more."""
    if value is None:
        return ""
    if unit == "":
        return f"{value:,.0f}"
    sizes = UNITS[unit]
    size, name = next((one for one in sizes if abs(value) >= 0.9995 * one[0]), sizes[-1])
    scaled = value / size
    digits = max(0, 2 - math.floor(math.log10(scaled))) if scaled > 0.0 else 0
    text = f"{scaled:,.{min(digits, 2)}f}"
    return f"{text.rstrip('0').rstrip('.') if '.' in text else text} {name}"


def _policy(
    found: Measured,
    name: str,
    answering: str,
    answer_s: float,
    stored: float,
    total_s: float,
    animated_s: float,
) -> Iterable[Row]:
    """What the paper tells of one policy, and ours beside."""
    own = found.costs[name]
    alone = _deciding_s(found, name)
    crossing_s = found.compared[found.extent.at].pilots[name].mean("time_s")
    dt_s = found.demonstrated_s / found.pairs
    frames = None if crossing_s is None else crossing_s / dt_s
    yield Row(name, answering, "s", answer_s, own.answer_s)
    yield Row(name, "the same, perception included", "s", None, alone)
    yield Row(name, "Storage requirements: memory", "B", stored, own.memory_bytes)
    yield Row(name, "Storage requirements: file", "B", None, own.file_bytes)
    answers = None if frames is None else frames * own.answer_s
    yield Row(name, "Total decision-making time to cross field", "s", total_s, answers)
    yield _total(found, name, None)
    yield from _crossed(found, name, animated_s)


def _deciding_s(found: Measured, name: str) -> float:
    flown = found.crossings[name]
    return sum(one.deciding_s for one in flown) / sum(one.decisions for one in flown)


def _total(found: Measured, name: str, paper: float | None) -> Row:
    took = [one.deciding_s for one in found.crossings[name] if one.good]
    what = "Total decision-making time to cross field"
    if paper is None:
        what = "the same, perception included"
    mean = float(np.mean(took)) if took else None
    return Row(name, what, "s", paper, mean, note="" if took else "no field was crossed")


def _crossed(found: Measured, name: str, animated_s: float) -> Iterable[Row]:
    own = found.compared[found.extent.at].pilots[name]
    mean = own.mean("time_s")
    times = own.figures["time_s"][own.succeeded]
    yield Row(
        *(name, "Total animation time to cross field", "s", animated_s, mean),
        interval=mean_interval(times) if len(times) else None,
    )
    low, high = own.interval
    yield Row(
        *(name, f"Fields crossed at NH {found.extent.at:g}", "%", None, 100 * own.success_rate),
        interval=(100 * low, 100 * high),
    )


def _table(rows: Sequence[Row]) -> list[str]:
    lines = ["| | | the paper | here | |", "|---|---|---:|---:|---|"]
    before = ""
    for row in rows:
        here = quantity(row.here, row.unit)
        if row.interval is not None:
            here += f" ({row.interval[0]:.1f} to {row.interval[1]:.1f})"
        group = f"**{row.group}**" if row.group != before else ""
        paper = quantity(row.paper, row.unit)
        lines.append(f"| {group} | {row.what} | {paper} | {here} | {row.note} |")
        before = row.group
    return lines
