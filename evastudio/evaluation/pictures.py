"""Pictures of evaluations: how many crossed, the ways flown, what was done, how search went.

Drawn by matplotlib, which is the extra `evastudio[pictures]`; nothing else of evastudio needs it.
The same figures give the same bytes, with the same version of matplotlib. Colours are those of
M. Okabe, K. Ito, "Color universal design", 2008 (the last one of P. Tol, 2021), which colour-blind
people tell apart, and every line has its name beside it.
"""

from __future__ import annotations

import io
from collections.abc import Mapping, Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass
from importlib.util import find_spec
from itertools import cycle, islice
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from evastudio.errors import ConflictError, NotFoundError
from evastudio.evaluation.flight import Flight
from evastudio.evaluation.interval import Interval
from evastudio.evaluation.results import Comparison
from evastudio.world.cast import of_lead
from evastudio.world.scene import Scene
from evastudio.world.spaces import Array, Symbols
from evastudio.writing import write_whole

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

FORMS = ("svg", "png")
COLORS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#333333", "#882255")
MARKERS = ("o", "s", "^", "D", "v", "P", "X", "*")
DASHES = ("-", "--", ":")
"""Pilots beyond the last colour have the colours again, dashed."""
STYLE: Mapping[str, Any] = {
    "svg.hashsalt": "evastudio",
    "svg.fonttype": "none",
    "font.family": "sans-serif",
    "font.size": 9.0,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.edgecolor": "#888888",
    "axes.titlesize": 10.0,
    "axes.titlelocation": "left",
    "axes.titlepad": 10.0,
    "axes.labelcolor": "#333333",
    "xtick.color": "#555555",
    "ytick.color": "#555555",
    "axes.grid": True,
    "axes.axisbelow": True,
    "grid.color": "#e4e4e4",
    "grid.linewidth": 0.6,
    "lines.linewidth": 1.5,
    "legend.frameon": False,
}
BINS = 21
"""Of a histogram: odd, so that rest has a bin of its own."""
BESIDE_M = 15.0
"""From above, what is farther to the side of a path is not drawn."""

EARLY = 0.8
"""Lines that end before this share of the way are named where they end."""
LINE_IN = 0.165
"""Height of a name, inches."""

Rate = tuple[float, Interval]
"""A share, and its interval."""


@dataclass(frozen=True)
class Curve:
    """A line through points, in order."""

    across: Sequence[float]
    up: Sequence[float]


def ready() -> None:
    """Raise ConflictError where pictures cannot be drawn."""
    if find_spec("matplotlib") is None:  # importing it takes long, and a server must not wait
        raise ConflictError(
            "Pictures are drawn by matplotlib, which is not installed. Install it with: "
            "pip install 'evastudio[pictures]'."
        )


def crossing_curves(
    rates: Mapping[str, Mapping[float, Rate]], across: str, title: str = "Worlds ended well"
) -> Figure:
    """The share that succeeded, by pilot, over what `across` names, with 95 % intervals.

    Pilots stand a little beside each other, so that all can be seen where all are as good.
    """
    figure, axes = _sheet(7.6, 4.2, title, across, "worlds, %")
    with _styled():
        marks = sorted({at for by in rates.values() for at in by})
        aside = 0.012 * (marks[-1] - marks[0])
        for number, ((name, by), (color, marker, dash)) in enumerate(
            zip(rates.items(), _looks(len(rates)), strict=True)
        ):
            at = np.array(list(by)) + aside * (number - (len(rates) - 1) / 2)
            middle, low, high = (
                np.array([(rate, *interval) for rate, interval in by.values()]).T * 100.0
            )
            axes.plot(at, middle, dash, color=color, marker=marker, markersize=4.5, label=name)
            axes.vlines(at, low, high, color=color, alpha=0.6, linewidth=1.2)
        axes.set(ylim=(-3.0, 103.0), xticks=marks)
        _name_lines(axes)
    return figure


def success_rates(comparison: Comparison) -> Figure:
    """The share of worlds that each pilot ended well, with its 95 % interval."""
    count = len(comparison.pilots)
    title = f"Worlds ended well, of {comparison.worlds:,}; bars: 95 % intervals"
    figure, axes = _sheet(7.0, 1.2 + 0.32 * count, title, "worlds, %", "")
    with _styled():
        for row, (one, (color, marker, _)) in enumerate(
            zip(comparison.pilots.values(), _looks(len(comparison.pilots)), strict=True)
        ):
            low, high = one.interval
            axes.plot((100 * low, 100 * high), (row, row), color=color, linewidth=2.5, alpha=0.4)
            axes.plot(100 * one.success_rate, row, marker, color=color)
            axes.annotate(
                f"{100 * one.success_rate:.1f}",
                (100 * high, row),
                (6, 0),
                textcoords="offset points",
                va="center",
                color=color,
            )
        axes.set(xlim=(0.0, 106.0), ylim=(count - 0.5, -0.5), xticks=range(0, 101, 20))
        axes.set_yticks(range(count), [*comparison.pilots])
        axes.tick_params(axis="y", length=0)
        axes.grid(axis="y", visible=False)
    return figure


def paths_from_above(
    scene: Scene, flights: Mapping[str, Flight], endings: Sequence[bool]
) -> Figure:
    """The ways that pilots took through one world, seen from above.

    `endings` says of each flight whether it ended well. Where the scene is a course, what reaches
    the height of a path beside it is drawn in its colour: crossing such a disc is hitting it.
    """
    ready()
    from matplotlib.patches import Circle

    paths = {name: scene.whereabouts(flight.moments) for name, flight in flights.items()}
    places = np.concatenate(list(paths.values()))
    low, high = places[:, :2].min(axis=0), places[:, :2].max(axis=0)
    margin = 0.02 * (high - low).max() + 4.0
    wide, tall = high - low + 2 * margin
    title = "The ways through one world, from above; x: ended badly"
    height = float(np.clip(6.4 * tall / wide, 0.9, 6.0))
    figure, axes = _sheet(8.4, height + 1.1, title, "m", "m")
    with _styled():
        axes.set(xlim=(low[0] - margin, high[0] + margin), ylim=(low[1] - margin, high[1] + margin))
        axes.set_aspect("equal")
        axes.grid(visible=False)
        for (name, path), good, (color, _, dash) in zip(
            paths.items(), endings, _looks(len(paths)), strict=True
        ):
            for x, y, radius in _in_the_way(scene, flights[name], path):
                axes.add_patch(Circle((x, y), radius, facecolor=color, alpha=0.3, linewidth=0.0))
            axes.plot(*path[0, :2], "o", color="#555555", markersize=4)
            axes.plot(path[:, 0], path[:, 1], dash, color=color, label=name, linewidth=1.2)
            if not good:
                axes.plot(*path[-1, :2], "x", color=color, markersize=7, markeredgewidth=2)
        if axes.patches:
            axes.set_title(f"{title}; discs: in the way at the height of the path")
        _name_lines(axes)
    return figure


def paths_in_space(scene: Scene, flights: Mapping[str, Flight], endings: Sequence[bool]) -> Figure:
    """The same ways in three dimensions, for a scene whose character has a height."""
    figure = _figure(7.6, 4.2)
    with _styled():
        from matplotlib.ticker import MaxNLocator

        axes = figure.add_subplot(projection="3d")
        axes.set_title("The same ways in space; x: ended badly", y=0.94)
        for (name, flight), good, (color, _, dash) in zip(
            flights.items(), endings, _looks(len(flights)), strict=True
        ):
            path = scene.whereabouts(flight.moments)
            axes.plot(*path.T, dash, color=color, label=name, linewidth=1.2)
            if not good:
                axes.plot(*path[-1:].T, "x", color=color, markersize=7, markeredgewidth=2)
        axes.set(xlabel="x, m", ylabel="y, m", zlabel="z, m")
        for axis in (axes.xaxis, axes.yaxis, axes.zaxis):
            axis.set_major_locator(MaxNLocator(4))
        axes.xaxis.labelpad = 14.0
        axes.set_box_aspect((3.0, 1.3, 1.0), zoom=1.3)
        axes.view_init(elev=24.0, azim=-66.0)
        axes.legend(
            labelcolor="linecolor", handlelength=1.2, loc="upper left", bbox_to_anchor=(1.0, 1.05)
        )
    return figure


def action_histograms(scene: Scene, flights: Mapping[str, Sequence[Flight]]) -> Figure:
    """How often each action was taken: a row for each pilot, a column for each component."""
    acted = {
        name: np.concatenate([of_lead(one.moments, one.actions) for one in own])
        for name, own in flights.items()
    }
    symbols = scene.action.names if isinstance(scene.action, Symbols) else ()
    names = (
        ("",)
        if isinstance(scene.action, Symbols)
        else tuple(_with_unit(field.name, field.unit) for field in scene.action.fields)
    )
    used = [
        number
        for number in range(len(names))
        if len({float(value) for one in acted.values() for value in one[:, number]}) > 1
    ] or [0]
    figure = _figure(7.6, 1.0 + 0.8 * len(acted))
    with _styled():
        grid = figure.subplots(len(acted), len(used), squeeze=False, sharex="col", sharey=True)
        figure.suptitle("How often each action was taken, % of the decisions", x=0.02, ha="left")
        for row, (name, actions), (color, *_) in zip(
            grid, acted.items(), _looks(len(acted)), strict=True
        ):
            row[0].set_title(name, color=color, pad=3.0)
            for number, axes in zip(used, row, strict=True):
                axes.set(yscale="symlog", ylim=(0.0, 130.0))
                axes.set_yticks((0, 1, 10, 100), ("0", "1", "10", "100"))
                axes.minorticks_off()
                edges = _edges(symbols, [one[:, number] for one in acted.values()])
                counts = np.histogram(actions[:, number], edges)[0]
                axes.stairs(100.0 * counts / len(actions), edges, fill=True, color=color)
        for number, axes in zip(used, grid[-1], strict=True):
            axes.set_xlabel(names[number])
        if symbols:
            grid[-1, 0].set_xticks(range(len(symbols)), symbols)
    return figure


def learning_curves(curves: Mapping[str, Curve], across: str, up: str, title: str) -> Figure:
    """How good the best policy was, over the time or the decisions that it took."""
    figure, axes = _sheet(7.6, 3.8, title, across, up)
    with _styled():
        for (name, curve), (color, _, dash) in zip(
            curves.items(), _looks(len(curves)), strict=True
        ):
            axes.plot(curve.across, curve.up, dash, color=color, label=name)
        axes.set(xlim=(0.0, None))
        _name_lines(axes)
    return figure


def drawn(figure: Figure, form: str) -> bytes:
    """The picture as a file's bytes, `form` one of FORMS. Raises NotFoundError for another."""
    if form not in FORMS:
        raise NotFoundError(f"There is no picture as {form!r}; choose {' or '.join(FORMS)}.")
    file = io.BytesIO()
    unsaid = {"Date": None, "Creator": None} if form == "svg" else {"Software": None}
    with _styled():
        figure.savefig(file, format=form, bbox_inches="tight", dpi=150, metadata=unsaid)
    return file.getvalue()


def save_pictures(figures: Mapping[str, Figure], folder: Path) -> list[Path]:
    """Every figure in every form, named by its name, in `folder`, which is made if need be.

    Raises StorageError where they cannot be written.
    """
    return [
        write_whole(folder / f"{name}.{form}", drawn(figure, form))
        for name, figure in figures.items()
        for form in FORMS
    ]


def _with_unit(name: str, unit: str) -> str:
    return name if unit == "1" else f"{name}, {unit}"


def _edges(symbols: Sequence[str], values: Sequence[Array]) -> Array:
    """Of the bins of a histogram: one a symbol, or as many to either side of zero."""
    if symbols:
        return np.arange(len(symbols) + 1.0) - 0.5
    widest = max(float(np.abs(one).max()) for one in values) or 1.0
    lowest = -widest if min(float(one.min()) for one in values) < 0.0 else 0.0
    return np.asarray(np.linspace(lowest, widest, BINS + 1))


def _in_the_way(scene: Scene, flight: Flight, path: Array) -> list[tuple[float, float, float]]:
    """Where balls beside a `path` (moments, 3) reach its height: centres and radii there."""
    try:
        course = scene.course(flight.moments.take(np.arange(1)))
    except NotFoundError:
        return []
    balls = course.balls[0]
    at = np.clip(np.searchsorted(path[:, 0], balls[:, 0]), 0, len(path) - 1)
    square = course.reach**2 - (balls[:, 2] - path[at, 2]) ** 2
    near = (square > 0.0) & (np.abs(balls[:, 1] - path[at, 1]) < BESIDE_M)
    near &= balls[:, 0] < path[-1, 0] + course.reach
    return [
        (float(x), float(y), float(radius))
        for (x, y, _), radius in zip(balls[near], np.sqrt(square[near]), strict=True)
    ]


def _looks(count: int) -> list[tuple[str, str, str]]:
    """Colour, marker and dash of each of `count` pilots."""
    looks = [
        (color, marker, dash)
        for dash in DASHES
        for color, marker in zip(COLORS, MARKERS, strict=True)
    ]
    return list(islice(cycle(looks), count))


def _styled() -> AbstractContextManager[None]:
    ready()
    import matplotlib as mpl

    styled: AbstractContextManager[None] = mpl.rc_context(dict(STYLE))
    return styled


def _figure(wide: float, tall: float) -> Figure:
    with _styled():
        from matplotlib.figure import Figure

        return Figure(figsize=(wide, tall), layout="constrained")


def _sheet(wide: float, tall: float, title: str, across: str, up: str) -> tuple[Figure, Axes]:
    figure = _figure(wide, tall)
    with _styled():
        axes = figure.subplots()
        axes.set(title=title, xlabel=across, ylabel=up)
    return figure, axes


def _name_lines(axes: Axes) -> None:
    """The name of each line where it ends; of lines that reach the right, beside, one by one."""
    ends = [
        (float(np.asarray(line.get_ydata())[-1]), float(np.asarray(line.get_xdata())[-1]), line)
        for line in axes.get_lines()
        if not str(line.get_label()).startswith("_")
    ]
    (left, right), (low, high) = axes.get_xlim(), axes.get_ylim()
    tall = float(axes.get_window_extent().height) / axes.figure.dpi
    gap = (high - low) * LINE_IN / tall
    at = high + gap
    for up, across, line in sorted(ends, key=lambda end: -end[0]):
        name, end = str(line.get_label()), (across, up)
        said: dict[str, Any] = {"color": line.get_color(), "va": "center", "annotation_clip": False}
        if across < left + EARLY * (right - left):
            paper = {"facecolor": "white", "edgecolor": "none", "alpha": 0.8, "pad": 0.5}
            axes.annotate(name, end, (8, 0), textcoords="offset points", bbox=paper, **said)
            continue
        at = min(up, at - gap)
        said["arrowprops"] = {
            **{"arrowstyle": "-", "color": line.get_color(), "lw": 0.5, "alpha": 0.6},
            **{"relpos": (0.0, 0.5), "shrinkA": 1.0, "shrinkB": 3.0},
        }
        axes.annotate(name, end, (right + 0.03 * (right - left), at), **said)
    axes.set_xlim(right=right)
