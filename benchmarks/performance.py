"""How fast learning is, beside what people would use instead: writes docs/performance.md.

    python benchmarks/performance.py            # 10 to 20 minutes
    python benchmarks/performance.py --quick    # small sets, once, to see that it runs

Every row is measured in this one run, ours and theirs in turn; see `neighbors.py` and `svr.py`.
"""

from __future__ import annotations

import argparse
import statistics
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path

import matplotlib as mpl

from benchmarks import fields, forgetting, neighbors, svr
from benchmarks.neighbors import BATCH, Cost, K
from benchmarks.report import ROOT, commit, where_and_when, write_section
from benchmarks.steering import steered
from benchmarks.svr import Row, timed
from evastudio.learning.conflicts import ConflictEliminator
from evastudio.learning.kernels.sharing import THREADS
from evastudio.learning.knn import KNNPolicy

mpl.use("svg")
mpl.rcParams["svg.hashsalt"] = "evastudio"
from matplotlib import pyplot  # noqa: E402 - after the choice of how to draw

PAPER = {"cleaning": 16.0, "training": 150.0, "k-NN": 13e-6, "SVR": 2e-6}
"""Seconds that the paper reports for about 6,000 pairs, on a machine of its time."""

PROFILE = """\
## Where the time of one decision goes

One k-NN decision from 6,000 pairs takes about 2.8 us here. About 1.4 us has nothing to do with
searching: 0.2 us to allocate the answer, 0.4 us for numba to take three arguments, the rest for
Python's frames, scratch memory, standardising and weighing. The search takes the other 1.4 us: it
looks at 22 boxes of eight children (12 ns each, sorting included) and 27 leaves of 16 points
(7 ns each), and keeps 25 candidates (5 ns each), of which about 0.6 us is vector arithmetic that
no layout of ours avoids. The tree of 6,000 pairs fits the second-level cache; at 100,000 the
extra time is mostly memory (inferred: the machine has no hardware counters to count with).

Tried without gain: boxes along principal axes, leaves of 8, unrolled loops, sorted queries.
"""


def text_of(seconds: Sequence[float]) -> str:
    """The median, in a unit that reads well."""
    middle = statistics.median(seconds)
    for unit, size in (("s", 1.0), ("ms", 1e-3)):
        if middle >= size / 2:
            return f"{middle / size:.2f} {unit}"
    return f"{middle / 1e-6:.2f} us"


def table(rows: Sequence[Row]) -> list[str]:
    """The rows beside their peers, in Markdown."""
    lines = [
        "| what | against | ours, CPU | peer, CPU | ratio, CPU | ratio, wall | at least | |",
        "|---|---|---:|---:|---:|---:|---:|---|",
    ]
    for row in rows:
        wall = statistics.median(row.peer_wall_s) / statistics.median(row.ours_wall_s)
        bar = f"{row.at_least:g}x" if row.at_least > 1.0 else ""
        lines.append(
            f"| {row.what} | {row.peer} | {text_of(row.ours_s)} | {text_of(row.peer_s)} | "
            f"{row.ratio:.1f}x | {wall:.1f}x | {bar} | {row.note} |"
        )
    return lines


def beside_the_paper(training: Row, compact: Row, pairs: int) -> list[str]:
    """Ours beside the paper's own figures."""
    states, actions = steered(pairs, 1)
    learner = KNNPolicy(K, "distance").fit(states, actions)
    one = steered(1, 2)[0][:1]
    learner.decide(one)
    cleaning = [timed(lambda: ConflictEliminator().fit(states, actions))[0] for _ in range(5)]
    deciding = [timed(lambda: [learner.decide(one) for _ in range(1000)])[0] for _ in range(5)]
    ours = {
        "cleaning": cleaning,
        "training": training.ours_s,
        "k-NN": [spent / 1000 for spent in deciding],
        "SVR": compact.ours_s,
    }
    return [
        "| 6,000 pairs | the paper | here |",
        "|---|---:|---:|",
        *(f"| {what} | {text_of([PAPER[what]])} | {text_of(ours[what])} |" for what in PAPER),
    ]


def draw(costs: Sequence[Cost], path: Path) -> None:
    """The cost of a pair over the number of pairs."""
    sizes = [one.pairs for one in costs]
    figure, axes = pyplot.subplots(figsize=(7, 4))
    for label, values in (
        ("building the index, a pair", [1e6 * one.build_s / one.pairs for one in costs]),
        ("one decision", [1e6 * one.decision_s for one in costs]),
        ("a decision of a batch", [1e6 * one.batch_s for one in costs]),
        ("cleaning, a pair", [1e6 * one.clean_s / one.pairs for one in costs]),
    ):
        axes.plot(sizes, values, marker="o", label=label)
    axes.set(xscale="log", xlabel="pairs", ylabel="CPU time, us", ylim=(0, None))
    axes.grid(alpha=0.3)
    axes.legend(frameon=False)
    figure.savefig(path, bbox_inches="tight", metadata={"Date": None})


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="small sets, once")
    options = parser.parse_args()
    quick = options.quick
    began = time.monotonic()
    at = commit("evastudio/learning", "benchmarks")
    docs = Path(tempfile.mkdtemp()) if quick else ROOT / "docs"
    near = neighbors.measure(quick)
    print("\n".join(table(near)), flush=True)
    machines = svr.measure(quick, grid=False)
    print("\n".join(table(machines)), flush=True)
    first = neighbors.first_decision(1 if quick else 5)
    more = neighbors.apart(neighbors.cleaning_memory, 20_000 if quick else 1_000_000)
    data = svr.recorded(2000 if quick else svr.PAIRS)
    peaks = [svr.peak_megabytes(whose, data) for whose in ("ours", "theirs")]
    costs = neighbors.curve(quick)
    draw(costs, docs / "performance.svg")
    lines = [
        "# Performance of learning",
        "",
        "Written by `make bench`; do not edit by hand.",
        "",
        where_and_when(at, "make bench", time.monotonic() - began),
        f"- Pairs have 8 components and 2 actions, k = {K}, neighbours weigh one over their "
        "distance. Neighbours: pairs of a steering policy, queries from other worlds "
        "(`benchmarks/steering.py`). SVR: the scripted `human` demonstrator, under `paper`.",
        "- Ours and theirs take turns in one process; medians; CPU time of the process and wall "
        f"time. One decision runs on one thread, a batch of {BATCH:,} and cleaning on {THREADS}. "
        "Peers get their best leaf size of 8, 16 and 32 for decisions, float32 where that is "
        "faster, and all processors where that is faster. Both sides do the whole work: "
        "standardise, search, average.",
        "- Machines here are shared: read the ratios, not the times.",
        "",
        *table([*near, *machines]),
        "",
        f"- First decision of a fresh process, caches warm: {text_of(first)} CPU for the whole "
        "process, imports and policy file included (at most 2 s).",
        f"- Cleaning 1,000,000 pairs adds {more:.0f} MB to what the process held (at most 500).",
        f"- Training the SVR adds {peaks[0]:.0f} MB, scikit-learn's two {peaks[1]:.0f} MB.",
        "",
        "## Beside the paper",
        "",
        *beside_the_paper(machines[0], machines[1], 1000 if quick else 6000),
        "",
        "The paper's machine was of 2007; the ratio says as much about machines as about us.",
        "",
        "## How costs grow",
        "",
        "![CPU time over the number of pairs](performance.svg)",
        "",
        "| pairs | build, us a pair | one decision, us | of a batch, us | clean, us a pair | "
        "peak memory, pairs included |",
        "|---:|---:|---:|---:|---:|---:|",
        *(
            f"| {one.pairs:,} | {1e6 * one.build_s / one.pairs:.2f} | {1e6 * one.decision_s:.2f} "
            f"| {1e6 * one.batch_s:.2f} | {1e6 * one.clean_s / one.pairs:.2f} "
            f"| {one.peak_mb:,.0f} MB |"
            for one in costs
        ),
        "",
        PROFILE,
    ]
    write_section(docs / "performance.md", "learning", "\n".join(lines))
    for part in (fields.PART, forgetting.PART):
        part.write(docs, quick)
    print((docs / "performance.md").read_text(encoding="utf-8"))


if __name__ == "__main__":
    main()
