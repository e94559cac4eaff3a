"""What was measured on the recordings of people, in Markdown."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from benchmarks.real.closed_loop import FIRST_SEED, Played
from benchmarks.real.offline import CLEANED, CONDITIONS, RAW, RESCUED, SPOILT, Measured
from evastudio.evaluation.interval import wilson_interval

INTRODUCTION = (
    "People made these recordings: Push-T (Columbia University, MIT), door (hand_dapg, "
    "Apache-2.0), walkers (Pedestrian Dynamics Data Archive, Forschungszentrum Jülich and "
    "University of Wuppertal, CC BY 4.0). Nothing of them is in this repository.",
    "Error: root mean square on what was held out, each component of the action in units of its "
    "standard deviation; a constant makes about 1. Mean over {folds} folds, the range behind it. "
    "Whole demonstrations are held out, of the walkers whole experiments. Every setting was chosen "
    "on demonstrations held out of those learned from, anew in each fold and condition.",
    'Cleaned: `ConflictEliminator(threshold="auto")` on what is learned from, never on what is '
    "held out.",
    "Outliers: 10 % of the actions learned from, drawn anew and evenly from the range of each "
    "component. Late: each action moved to the state so much later in its demonstration; taken "
    "out: after `estimate_delay`, where it decides so. What is held out stays as it was.",
    "SVR is fitted to at most 5,000 pairs and, like the MLP, tuned on 2,500; everyone learns "
    "walking from about 6,000. MLP: scikit-learn's, two hidden layers of 64, stopped early.",
)

PUBLISHED = (
    "Published, for other policies, by their own papers' protocols and not in this run: LSTM-GMM "
    ".67, BET .79, IBC .90, Diffusion Policy .95. A first look at these data, plain and one step "
    "at a time: k-NN with k=7 .47, SVR .26, MLP .43; cleaned .36, .31, .57."
)


@dataclass(frozen=True)
class Bout:
    """A learner that played Push-T."""

    learner: str
    perception: str
    chunk: int
    clean: bool
    settings: str
    played: Played


def spread(values: Sequence[float], form: str = "{:.3f}") -> str:
    """Mean and range."""
    if len(values) == 0 or not np.isfinite(values).all():
        return ""
    low, high = form.format(min(values)), form.format(max(values))
    mean = form.format(float(np.mean(values)))
    return mean if low == high else f"{mean} ({low} to {high})"


def bootstrap(scores: Sequence[float]) -> tuple[float, float]:
    """A 95 % interval of the mean: percentiles over 10,000 resamples with a fixed seed."""
    rng = np.random.default_rng(0)
    values = np.asarray(scores)
    means = rng.choice(values, (10_000, len(values))).mean(axis=1)
    low, high = np.percentile(means, [2.5, 97.5])
    return float(low), float(high)


def select(rows: Sequence[Measured], learner: str, condition: str) -> list[Measured]:
    """The folds of one learner in one condition."""
    return [row for row in rows if row.learner == learner and row.condition == condition]


def change(rows: Sequence[Measured], learner: str, condition: str) -> float:
    """How much larger the mean error is than on the recording as it is, in %."""
    before = np.mean([row.error for row in select(rows, learner, RAW)])
    after = np.mean([row.error for row in select(rows, learner, condition)])
    return float(100 * (after / before - 1))


def names(rows: Sequence[Measured], field: str) -> list[str]:
    """The different values of a field, in their order."""
    return list(dict.fromkeys(getattr(row, field) for row in rows))


def recording_section(title: str, rows: Sequence[Measured]) -> list[str]:
    """Errors of everyone on one recording, and what cleaning did."""
    met = [name for name in CONDITIONS if any(row.condition == name for row in rows)]
    lines = [f"### {title}", "", "| learner | " + " | ".join(met) + " | settings, raw, fold 1 |"]
    lines.append("|---|" + "---:|" * len(met) + "---|")
    for learner in names(rows, "learner"):
        cells = [spread([row.error for row in select(rows, learner, one)]) for one in met]
        settings = select(rows, learner, RAW)[0].settings
        lines.append(f"| {learner} | " + " | ".join([*cells, settings]) + " |")
    cut = {one: [row.cut for row in rows if row.condition == one] for one in met}
    notes = []
    for one in (CLEANED, RESCUED):
        if cut.get(one):
            notes.append(f"{one}: {100 * float(np.mean(cut[one])):.1f} % of the pairs cut")
    marked = [row.marked for row in rows if row.condition == RESCUED]
    if marked:
        notes.append(f"{100 * float(np.mean(marked)):.0f} % of the outliers among them")
    return [*lines, "", "; ".join(notes) + ".", ""]


def criteria(rows: Sequence[Measured]) -> list[str]:
    """Cleaning against what it should do, for each of our learners."""
    lines = [
        "### What cleaning does to the error, %",
        "",
        "Against the same learner on the recording as it is. Wanted: untouched data at most 2 % "
        "worse by cleaning, with outliers at most 5 % worse once cleaned.",
        "",
        "| recording | learner | untouched, cleaned | 10 % outliers | 10 % outliers, cleaned "
        "| within 2 % | within 5 % |",
        "|---|---|---:|---:|---:|---|---|",
    ]
    for title in names(rows, "recording"):
        own = [row for row in rows if row.recording == title]
        for learner in names(own, "learner"):
            if learner == "constant":
                continue
            cells = []
            harm = change(own, learner, CLEANED)
            cells.append(f"{harm:+.1f}")
            left = None
            if select(own, learner, RESCUED):
                left = change(own, learner, RESCUED)
                cells += [f"{change(own, learner, SPOILT):+.1f}", f"{left:+.1f}"]
            else:
                cells += ["", ""]
            cells.append("yes" if harm <= 2.0 else "no")
            cells.append("" if left is None else "yes" if left <= 5.0 else "no")
            lines.append(f"| {title} | {learner} | " + " | ".join(cells) + " |")
    return [*lines, ""]


def rollouts(rows: Sequence[Measured], references: Mapping[str, Sequence[float]]) -> list[str]:
    """Where walkers are 12 steps on."""
    lines = [
        "## Walkers rolled out",
        "",
        "Mean distance in m to where people really were, over 12 steps (4.5 to 4.8 s); everybody "
        "is rolled out together and nobody's future is known but the goal. Range over the folds; "
        "of the references, over the experiments. First look: SVR .24, k-NN .30, constant "
        "velocity .44.",
        "",
        "| | as recorded | cleaned |",
        "|---|---:|---:|",
    ]
    for name, values in references.items():
        lines.append(f"| {name} | {spread(values, '{:.2f}')} | |")
    for learner in names(rows, "learner"):
        if learner == "constant":
            continue
        cells = [
            spread([row.rolled for row in select(rows, learner, one)], "{:.3f}")
            for one in (RAW, CLEANED)
        ]
        lines.append(f"| {learner} | " + " | ".join(cells) + " |")
    return [*lines, ""]


def closed_loop(bouts: Sequence[Bout]) -> list[str]:
    """Push-T played."""
    episodes = len(bouts[0].played.scores)
    lines = [
        f"Mean largest coverage of the goal over {episodes} episodes (seeds from {FIRST_SEED:,}), "
        "with its 95 % interval (bootstrap over episodes); solved: episodes at 95 % coverage, with "
        "the Wilson interval. Fitted to all 206 demonstrations; settings chosen on demonstrations "
        "held out, not by playing. `plain`: the five numbers, actions relative to the agent; "
        "`block`: seen from the block, mirrored. Steps at once: how many targets one decision "
        "gives. That the nearest pair alone is played, and the steps at once, was picked by "
        "playing 30 other seeds.",
        "",
        PUBLISHED,
        "",
        "| learner | perception | steps at once | score | solved, % | score, cleaned "
        "| solved, cleaned, % | settings |",
        "|---|---|---:|---:|---:|---:|---:|---|",
    ]
    for bout in bouts:
        if bout.clean:
            continue
        cells = []
        for clean in (False, True):
            for other in bouts:
                same = (other.learner, other.perception, other.chunk, other.clean)
                if same != (bout.learner, bout.perception, bout.chunk, clean):
                    continue
                scores = other.played.scores
                low, high = bootstrap(scores)
                cells.append(f"{scores.mean():.2f} ({low:.2f} to {high:.2f})")
                low, high = wilson_interval(other.played.solved, episodes)
                share = 100 * other.played.solved / episodes
                cells.append(f"{share:.0f} ({100 * low:.0f} to {100 * high:.0f})")
        cells += [""] * (4 - len(cells))
        lines.append(
            f"| {bout.learner} | `{bout.perception}` | {bout.chunk} | "
            + " | ".join([*cells, bout.settings])
            + " |"
        )
    return [*lines, ""]


def errors_report(
    rows: Sequence[Measured],
    references: Mapping[str, Sequence[float]],
    delays: Mapping[str, str],
    measured: str,
    folds: int,
) -> str:
    """The section on what was held out, and the walkers' rollouts."""
    lines = [
        "# Results: recordings of people",
        "",
        "Written by `make bench-real`; do not edit.",
        "",
    ]
    lines += [measured, *(f"- {line.format(folds=folds)}" for line in INTRODUCTION), ""]
    lines += ["## Errors on demonstrations held out", ""]
    for title in names(rows, "recording"):
        lines += recording_section(title, [row for row in rows if row.recording == title])
    lines += criteria(rows)
    if delays:
        lines += ["### Reaction delay of the recordings as they are", ""]
        lines += [*(f"- {name}: {said}" for name, said in delays.items()), ""]
    walked = [row for row in rows if np.isfinite(row.rolled)]
    return "\n".join(lines + (rollouts(walked, references) if walked else []))


def played_report(bouts: Sequence[Bout], measured: str) -> str:
    """The section on Push-T in a closed loop."""
    return "\n".join(["# Results: Push-T played", "", measured, "", *closed_loop(bouts)])
