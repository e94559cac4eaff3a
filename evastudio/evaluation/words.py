"""What an evaluation found, in words that need no statistics."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from evastudio.evaluation.results import SUCCESS

SURE = 0.05
"""A corrected p-value below this is not put down to luck."""


@dataclass(frozen=True)
class Figure:
    """What a person reads of a figure."""

    label: str
    less: str
    """What a pilot does whose figure is less than another's."""
    more: str
    unit: str = ""
    """None where the number means little to people."""
    scale: float = 1.0
    """What it is multiplied by to be in `unit`."""


FIGURES: Mapping[str, Figure] = {
    SUCCESS: Figure("Worlds ended well", "", "", "%", 100.0),
    "time_s": Figure("Time needed", "needs less time", "needs more time", "s"),
    "turn": Figure(
        "Change from step to step", "steers more calmly", "steers more restlessly", "%", 100.0
    ),
    "closest_m": Figure("Closest to an obstacle", "comes closer", "keeps farther away", "m"),
    "near_misses": Figure(
        "Near misses", "has fewer near misses", "has more near misses", "a world"
    ),
    "jerk": Figure(
        "Smoothness of the pace", "changes pace more jerkily", "changes pace more gently"
    ),
    "arc_length": Figure("Smoothness of the turns", "turns less smoothly", "turns more smoothly"),
    "unlike": Figure("Unlike the one to be like", "", "", "%", 100.0),
    "decision_us": Figure("Time of a decision", "", "", "µs"),
}
"""Of any scene; a scene's own are known by their names."""


def label(figure: str) -> str:
    """What `figure` is called, with its unit: 'Time needed, s'."""
    known = FIGURES.get(figure)
    if known is None:
        words = figure.removesuffix("_s").removesuffix("_m").replace("_", " ")
        unit = {"_s": "s", "_m": "m"}.get(figure[-2:], "")
        known = Figure(words[:1].upper() + words[1:], "", "", unit)
    return f"{known.label}, {known.unit}" if known.unit else known.label


def in_words(result: Mapping[str, Any]) -> list[str]:
    """A paragraph for each pair of pilots, from `Comparison.to_json()`, and one on likeness."""
    told = [_pair(result["pilots"], found) for found in result["differences"]]
    unlike = {name: one["unlike"] for name, one in result["pilots"].items()}
    others = [
        f"{name} by {_percent(value)}"
        for name, value in unlike.items()
        if value is not None and name != result["like"]
    ]
    if others and result.get("chance") is not None:
        told.append(
            f"How they move differs from {result['like']}: {_listed(others)}; chance alone gives "
            f"{_percent(result['chance'])}, and 0 % is the same."
        )
    return told


def _pair(pilots: Mapping[str, Any], found: Mapping[str, Any]) -> str:
    ours, theirs = found["pilots"]
    rates = [_percent(pilots[name][SUCCESS]) for name in (ours, theirs)]
    ending = found[SUCCESS]
    better, worse = (ours, theirs) if ending["difference"] > 0 else (theirs, ours)
    if _sure(ending):
        low, high = sorted(abs(100.0 * end) for end in ending["interval"])
        first = (
            f"{better} ends well more often than {worse}: {ours} in {rates[0]} of the worlds, "
            f"{theirs} in {rates[1]}; the true difference is likely {low:.1f} to {high:.1f} points."
        )
    elif ending["difference"] == 0.0:
        first = f"{ours} and {theirs} end well equally often, in {rates[0]} of the worlds."
    else:
        first = (
            f"{ours} ends well in {rates[0]} of the worlds and {theirs} in {rates[1]}; of "
            f"{ending['worlds']} worlds this may be luck, and more worlds would tell."
        )
    others = [
        _figure(name, one)
        for name, one in found.items()
        if name not in ("pilots", SUCCESS) and _sure(one)
    ]
    if not others:
        return (
            f"{first} No other difference is larger than luck makes in {ending['worlds']} worlds."
        )
    return f"{first} In the same worlds, {ours} {_listed(others)}."


def _figure(name: str, found: Mapping[str, Any]) -> str:
    change = found["difference"]
    known = FIGURES.get(name)
    if known is None:
        return f"has {'less' if change < 0 else 'more'} in “{label(name)}” ({abs(change):.3g})"
    words = known.less if change < 0 else known.more
    return f"{words} ({abs(change) * known.scale:.3g} {known.unit})" if known.unit else words


def _percent(share: float) -> str:
    return f"{100.0 * share:.1f} %"


def _sure(found: Mapping[str, Any]) -> bool:
    return bool(found.get("p_corrected", found["p"]) < SURE)


def _listed(words: list[str]) -> str:
    return words[0] if len(words) == 1 else f"{', '.join(words[:-1])} and {words[-1]}"
