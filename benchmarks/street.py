"""How near do policies fitted to recorded people come to the people?

    python -m benchmarks.street            # a section of docs/street.md
    python -m benchmarks.street --quick    # few people of few recordings, to see that it runs

Recordings are read from outside the repository, see `benchmarks/real_data.py`. Whole recordings
are held out, each once; the others are learned from. Either one goes on by the policy among the
others as recorded, or everybody does.
"""

from __future__ import annotations

import argparse
import os
import sys
import tempfile
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.real.recordings import VARIABLE, data_folder
from benchmarks.real.streets import (
    AHEAD,
    LATE,
    STREET,
    TOUCH_M,
    Crowded,
    Decide,
    Led,
    Rolled,
    crowd,
    joined,
    led,
    mirrored,
    recording,
    roll,
)
from benchmarks.real.walking import EXPERIMENTS, ConstantVelocity, StraightToGoal
from benchmarks.remaking import apart
from benchmarks.report import ROOT, commit, where_and_when, write_section
from evastudio.demonstrations.retracing import Stepped
from evastudio.learning.cleaning import clean_pairs
from evastudio.learning.compiled import ensure_compiled
from evastudio.learning.policy import LEARNERS
from evastudio.world.scene import Scene
from evastudio.world.snapshot import Snapshot
from evastudio.world.spaces import Array

FOLDS = 3
PEOPLE = 14
"""Leads of each recording, learned from and held out."""
MOST = 3000
"""Pairs that are learned from at most."""
CROWD_STEPS = 75
"""Steps for which everybody goes on by the same, 30 s."""
UCY = ("crowds_zara01", "crowds_zara02", "students003")
BROAD: Mapping[str, Any] = {"C": 1.0, "gamma": 0.01, "epsilon": 0.2}
NARROW: Mapping[str, Any] = {"C": 1.0, "gamma": 0.05, "epsilon": 0.05}


@dataclass(frozen=True)
class Contender:
    """A way to learn from people."""

    name: str
    perception: str
    learner: str
    settings: Mapping[str, Any]
    mirror: bool = False
    """Learns from every pair and its mirror image."""
    clean: bool = False
    beside: bool = False
    """Learns what people do beside walking straight to the goal at the speed they have."""
    alone: bool = True
    """Is also tried where everybody goes on by it."""

    def fitted(self, leads: Sequence[Led]) -> Decide:
        """Its decisions for all characters, fitted to what `leads` did."""
        scene = STREET()
        view = scene.perceptions[self.perception]
        pairs = joined(leads, view)
        if self.clean:
            pairs = clean_pairs(pairs, scene, self.perception, threshold="auto").apply(pairs)
        kept = np.zeros(len(pairs), dtype=bool)
        kept[np.random.default_rng(0).permutation(len(pairs))[:MOST]] = True
        pairs = pairs.keep(kept)
        if self.mirror:
            signs = [-1.0 if "left" in name else 1.0 for name in view.state.names]
            pairs = mirrored(pairs, np.array(signs))
        straight = StraightToGoal().predict
        if self.beside:
            pairs = replace(pairs, actions=pairs.actions - straight(pairs.states))
        learner = LEARNERS[self.learner](**self.settings)
        learner.learn(pairs.states, pairs.actions, scene.chosen(view), lambda share: None)
        if self.beside:
            return decided(self.perception, lambda s: straight(s) + learner.decide(s))
        return decided(self.perception, learner.decide)


CONTENDERS = (
    Contender("SVR, `goal`", "goal", "svr", BROAD),
    Contender("SVR, narrower (as shipped)", "goal", "svr", NARROW),
    Contender("SVR, with mirror images", "goal", "svr", BROAD, mirror=True),
    Contender("SVR, beside straight", "goal", "svr", {**BROAD, "C": 0.1}, beside=True),
    Contender("SVR, cleaned", "goal", "svr", BROAD, clean=True, alone=False),
    Contender("SVR, `walls`", "walls", "svr", BROAD),
    Contender("SVR, `flow`", "flow", "svr", NARROW),
    Contender("local linear, `goal`", "goal", "local-linear", {"k": 100}, alone=False),
)


def decided(perception: str, decide: Callable[[Array], Array]) -> Decide:
    """A decision by states, for all characters."""

    def act(scene: Scene, snapshot: Snapshot) -> Array:
        view = scene.perceptions[perception]
        percept = view.perceive(snapshot)
        own = decide(percept.states.reshape(-1, percept.states.shape[-1]))
        return view.to_world(percept.frame, own.reshape(*percept.states.shape[:-1], -1))

    return act


def scripted(scene: Scene, snapshot: Snapshot) -> Array:
    """What the scene's scripted demonstrator wants."""
    return scene.intention(snapshot)


KNOWING_NOTHING: Mapping[str, Decide | None] = {
    "the people themselves": None,
    "constant velocity": decided("goal", ConstantVelocity().predict),
    "straight to the goal, speed kept": decided("goal", StraightToGoal().predict),
    "scripted (1.3 m/s, gives way)": scripted,
}


@dataclass
class Row:
    """One line of a table."""

    led: list[Rolled] = field(default_factory=list)
    crowded: list[Crowded] = field(default_factory=list)

    def of_leads(self) -> str:
        """Errors and touches of those who were led."""
        forecast = np.concatenate([one.forecast for one in self.led])
        whole = np.concatenate([one.whole for one in self.led])
        touched = np.concatenate([one.touched for one in self.led])
        arrived = np.concatenate([one.arrived for one in self.led])
        return (
            f"{forecast.mean():.2f} | {forecast[:, -1].mean():.2f} | {whole.mean():.2f} | "
            f"{touched.mean():.2f} | {100 * arrived.mean():.0f}"
        )

    def of_crowds(self) -> str:
        """Touches and speeds where everybody did the same."""
        slow, usual, fast = np.percentile(
            np.concatenate([one.speeds for one in self.crowded]), (10, 50, 90)
        )
        touches = np.mean([one.touches for one in self.crowded])
        arrived = np.mean([one.arrived for one in self.crowded])
        return f"{touches:.1f} | {slow:.2f} | {usual:.2f} | {fast:.2f} | {100 * arrived:.0f}"


def measured(recordings: Sequence[Stepped], people: int, steps: int) -> dict[str, Row]:
    """Every contender on every recording, held out from what it learned from."""
    leads = [led(one, people) for one in recordings]
    rows: dict[str, Row] = {}

    def tell(name: str, number: int, decide: Decide | None, crowds: bool) -> None:
        row = rows.setdefault(name, Row())
        row.led.append(roll(leads[number], decide))
        if crowds:
            row.crowded.append(crowd(recordings[number], decide, steps))

    for name, decide in KNOWING_NOTHING.items():
        for number in range(len(leads)):
            tell(name, number, decide, True)
    for contender in CONTENDERS:
        for fold in range(min(FOLDS, len(leads))):
            decide = contender.fitted([one for at, one in enumerate(leads) if at % FOLDS != fold])
            for number in range(fold, len(leads), FOLDS):
                tell(contender.name, number, decide, contender.alone)
        print(contender.name, rows[contender.name].of_leads(), flush=True)
    return rows


def section(title: str, rows: Mapping[str, Row], what: str) -> list[str]:
    """The tables of one source of recordings."""
    lines = [f"### {title}", "", what, ""]
    lines += [
        f"| one goes on by | off after {AHEAD} steps, mean m | at the last, m | whole way, m "
        "| touches a person | arrived, % |",
        "|---|---:|---:|---:|---:|---:|",
    ]
    lines += [f"| {name} | {row.of_leads()} |" for name, row in rows.items()]
    lines += [
        "",
        "| everybody goes on by | touches a person-minute | speed 10 %, m/s | median | 90 % "
        "| gone at the end, % |",
        "|---|---:|---:|---:|---:|---:|",
    ]
    lines += [f"| {name} | {row.of_crowds()} |" for name, row in rows.items() if row.crowded]
    return [*lines, ""]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="three recordings each, 3 people")
    options = parser.parse_args()
    folder = data_folder()
    ensure_compiled()
    began = time.monotonic()
    at = commit("evastudio", "scenes", "benchmarks")
    people, steps = (3, 20) if options.quick else (PEOPLE, CROWD_STEPS)
    names = list(EXPERIMENTS)[: 3 if options.quick else None]
    juelich = [recording(folder / "juelich" / f"{name}.txt", None) for name in names]
    ucy = [recording(folder / "ucy" / f"{name}.txt", 25.0) for name in UCY]
    parts = section(
        "Jülich: corridors, a bottleneck, opposing streams",
        measured(juelich, people, steps),
        f"{len(juelich)} recordings, {people} people of each lead; held out in {FOLDS} folds. "
        "Pedestrian Dynamics Data Archive, Forschungszentrum Jülich and University of Wuppertal, "
        "CC BY 4.0.",
    )
    parts += section(
        "UCY: a street and a campus",
        measured(ucy, people, steps),
        f"{len(ucy)} recordings, {people} people of each lead; each held out once. Lerner, "
        "Chrysanthou, Lischinski, *Crowds by Example*, 2007.",
    )
    with tempfile.TemporaryDirectory() as place:
        os.environ[VARIABLE] = str(folder.resolve())
        shipped = apart(ROOT / "policies" / "street-people.safetensors", Path(place))
    where = where_and_when(
        at,
        f"python -m benchmarks.street {' '.join(sys.argv[1:])}".strip(),
        time.monotonic() - began,
    )
    text = "\n".join(
        [
            "## Measured",
            "",
            "Written by `make bench-street`; do not edit.",
            "",
            where,
            f"- `street-people`, made again by its own commands, differs by {shipped:.1e} of the "
            "actions' range.",
            f"- Off: metres from where the person was; forecasts begin every 24 steps ({AHEAD} "
            f"steps are {AHEAD * STREET.dt_s:.1f} s), whole ways at their beginning and until the "
            "person had arrived. The goal is where the person was last seen.",
            f"- A touch: two come nearer than {TOUCH_M:g} m. Arrived: at the goal within {LATE:g} "
            "times the person's own time. The ground of `walls` is where the others walked.",
            "",
            *parts,
        ]
    )
    print(text)
    if not options.quick:
        write_section(ROOT / "docs" / "street.md", "measured", text)


if __name__ == "__main__":
    main()
