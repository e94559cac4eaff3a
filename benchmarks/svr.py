"""SVR against scikit-learn in one interleaved run: training, and the decisions of a compact form.

    python benchmarks/svr.py            # the default settings, and a grid of others
    python benchmarks/svr.py --no-grid  # the default settings alone
    python benchmarks/svr.py --quick    # 2,000 pairs, one repetition, no grid

Pairs are those of the scripted `human` demonstrator on the asteroid field, in the paper's
perception (8 components, 2 actions). CPU time of this process, wall time beside; medians.
"""

from __future__ import annotations

import argparse
import multiprocessing
import os
import resource
import statistics
import tempfile
import time
from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from safetensors.numpy import load_file
from sklearn.svm import SVR

from benchmarks.crossing import demonstrate, middle, scene_at
from benchmarks.report import processor
from evastudio.learning.dual import dual_slopes, solve_dual
from evastudio.learning.fitting import fit_policy
from evastudio.learning.policy_files import save_policy
from evastudio.learning.svr import SVRPolicy
from evastudio.pilots.scripted import find_pilot
from evastudio.world.spaces import Array

PAIRS = 6000
BASES = 256
DEFAULT = (30.0, 0.2, 0.01)
"""C, epsilon, gamma: the studio's defaults."""
GRID = [(c, e, g) for g in (0.01, 0.1, 1.0) for c in (1.0, 10.0, 30.0) for e in (0.02, 0.1, 0.2)]


@dataclass(frozen=True)
class Row:
    """One figure beside its peer's."""

    what: str
    peer: str
    ours_s: Sequence[float]
    """CPU seconds, one for each repetition."""
    peer_s: Sequence[float]
    ours_wall_s: Sequence[float]
    peer_wall_s: Sequence[float]
    at_least: float
    """The ratio that must be shown."""
    note: str = ""

    @property
    def ratio(self) -> float:
        """How many times faster ours is, by the medians of CPU time."""
        return statistics.median(self.peer_s) / statistics.median(self.ours_s)


@dataclass(frozen=True)
class Data:
    """Pairs to learn from and others to be judged by, standardised, actions from -1 to 1."""

    states: Array
    actions: Array
    unseen_states: Array
    unseen_actions: Array


def recorded(pairs: int = PAIRS) -> Data:
    """Two independent demonstrations of the human-like pilot, seeds 1 and 2."""
    sets = [
        demonstrate(scene_at(4.0), find_pilot("scripted:human"), seed, 8.0)["paper"]
        for seed in (1, 2)
    ]
    states = sets[0].states[:pairs]
    actions = sets[0].actions[:pairs]
    offset, scale = states.mean(axis=0), states.std(axis=0)
    centre = (actions.max(axis=0) + actions.min(axis=0)) / 2
    half = (actions.max(axis=0) - actions.min(axis=0)) / 2
    return Data(
        (states - offset) / scale,
        (actions - centre) / half,
        (sets[1].states - offset) / scale,
        (sets[1].actions - centre) / half,
    )


def timed(function: Callable[[], Any]) -> tuple[float, float, Any]:
    """CPU seconds of this process, wall seconds, and the result."""
    wall, cpu = time.perf_counter(), time.process_time()
    result = function()
    return time.process_time() - cpu, time.perf_counter() - wall, result


def machines(data: Data, settings: tuple[float, float, float]) -> list[SVR]:
    """The peer: scikit-learn's SVR, one for each component of the action."""
    c, epsilon, gamma = settings
    return [
        SVR(C=c, epsilon=epsilon, gamma=gamma, cache_size=400).fit(data.states, column)
        for column in data.actions.T
    ]


def training(data: Data, settings: tuple[float, float, float], repeats: int) -> Row:
    """Solve for both outputs, ours and theirs in turn."""
    c, epsilon, gamma = settings
    ours, theirs = [], []
    for _ in range(repeats):
        ours.append(
            timed(lambda: solve_dual(data.states, data.actions, C=c, epsilon=epsilon, gamma=gamma))
        )
        theirs.append(timed(lambda: machines(data, settings)))
    objectives = []
    for machine, column in zip(theirs[-1][2], data.actions.T, strict=True):
        beta = np.zeros(len(data.states))
        beta[machine.support_] = machine.dual_coef_[0]
        slopes = dual_slopes(data.states, column, beta, gamma)
        objectives.append(epsilon * np.abs(beta).sum() - 0.5 * beta @ (column + slopes))
    apart = np.abs(ours[-1][2].objectives / np.array(objectives) - 1.0).max()
    return Row(
        f"SVR training, {len(data.states)} pairs, C={c:g} epsilon={epsilon:g} gamma={gamma:g}",
        "sklearn SVR twice",
        [one[0] for one in ours],
        [one[0] for one in theirs],
        [one[1] for one in ours],
        [one[1] for one in theirs],
        3.0,
        f"objective within {apart:.0e}, violation {ours[-1][2].violations.max():.1e}",
    )


def deciding(data: Data, repeats: int, rounds: int = 1000) -> Row:
    """One state at a time: the compact form against two full machines."""
    c, epsilon, gamma = DEFAULT
    policy = SVRPolicy(c, epsilon, gamma).fit(data.states, data.actions)
    compact = policy.compact(data.states, BASES)
    theirs = machines(data, DEFAULT)
    one = data.unseen_states[:1]
    compact.decide(one)
    ours_s, peer_s = [], []
    for _ in range(max(3, repeats)):
        cpu, wall, _ = timed(lambda: [compact.decide(one) for _ in range(rounds)])
        ours_s.append((cpu / rounds, wall / rounds))
        cpu, wall, _ = timed(lambda: [[m.predict(one) for m in theirs] for _ in range(50)])
        peer_s.append((cpu / 50, wall / 50))
    errors = [
        float(np.sqrt(((m.decide(data.unseen_states) - data.unseen_actions) ** 2).mean()))
        for m in (policy, compact)
    ]
    batch = timed(lambda: compact.decide(data.unseen_states))[0] / len(data.unseen_states)
    return Row(
        f"one decision, {len(compact.support_)} bases, {stored_bytes(compact, data)} bytes",
        f"two sklearn SVR.predict, {len(policy.support_)} support vectors",
        [cpu for cpu, _ in ours_s],
        [cpu for cpu, _ in peer_s],
        [wall for _, wall in ours_s],
        [wall for _, wall in peer_s],
        250.0,
        f"hold-out RMSE {errors[1]:.4f}, {100 * (errors[1] / errors[0] - 1):+.2f} % of the whole "
        f"one's; in a batch {1e6 * batch:.2f} us a state",
    )


def stored_bytes(compact: SVRPolicy, data: Data) -> int:
    """Bytes of the arrays in a policy file of `compact`'s settings."""
    scene = scene_at(4.0)
    pairs = demonstrate(scene, find_pilot("scripted:careful"), 3, 0.5)["paper"]
    policy = fit_policy(pairs, scene, "paper", "svr", compact.get_params())
    with tempfile.TemporaryDirectory() as folder:
        arrays = load_file(save_policy(policy, Path(folder) / "one.safetensors"))
    return sum(array.nbytes for array in arrays.values())


def peak_megabytes(whose: str, data: Data) -> float:
    """How far one training at the default settings raises the memory of a fresh process."""
    context = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(1, mp_context=context) as pool:
        return pool.submit(_peak, whose, data.states, data.actions).result()


def _peak(whose: str, states: Array, actions: Array) -> float:
    c, epsilon, gamma = DEFAULT
    peaks = []
    for count in (50, len(states)):  # the first loads and compiles what is needed
        data = Data(states[:count], actions[:count], states[:0], actions[:0])
        if whose == "ours":
            solve_dual(data.states, data.actions, C=c, epsilon=epsilon, gamma=gamma)
        else:
            machines(data, DEFAULT)
        peaks.append(_highest_kilobytes())
    return (peaks[1] - peaks[0]) / 1000


def _highest_kilobytes() -> int:
    """The most memory that this process has held; what the system counts includes its parent's."""
    try:
        status = Path("/proc/self/status").read_text()
        return int(status.partition("VmHWM:")[2].split()[0])
    except (OSError, IndexError):
        return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss


def measure(quick: bool = False, grid: bool = True) -> list[Row]:
    """All figures: the default settings first, then decisions, then the grid."""
    data = recorded(2000 if quick else PAIRS)
    repeats = 1 if quick else 5
    c, epsilon, gamma = DEFAULT
    solve_dual(data.states[:50], data.actions[:50], C=c, epsilon=epsilon, gamma=gamma)  # compile
    rows = [training(data, DEFAULT, repeats), deciding(data, repeats)]
    if grid and not quick:
        rows += [training(data, settings, 1) for settings in GRID]
    return rows


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="2,000 pairs, once, no grid")
    parser.add_argument("--no-grid", action="store_true", help="the default settings alone")
    options = parser.parse_args()
    print(f"{processor()}, {os.cpu_count()} cores")
    print("The paper: training 150 s, a decision 2 us.")
    for row in measure(options.quick, grid=not options.no_grid):
        form, unit = ("{:.2f} s", 1.0) if row.ours_s[0] > 1e-3 else ("{:.2f} us", 1e6)
        ours, theirs = (
            middle([unit * spent for spent in side], form) for side in (row.ours_s, row.peer_s)
        )
        print(
            f"{row.what}: {ours} CPU, {row.peer}: {theirs}; "
            f"{row.ratio:.1f}x (at least {row.at_least:g}x); wall "
            f"{statistics.median(row.peer_wall_s) / statistics.median(row.ours_wall_s):.1f}x; "
            f"{row.note}",
            flush=True,
        )
    data = recorded(2000 if options.quick else PAIRS)
    peaks = [peak_megabytes(whose, data) for whose in ("ours", "theirs")]
    print(f"Peak memory of training: {peaks[0]:.0f} MB, sklearn's {peaks[1]:.0f} MB")


if __name__ == "__main__":
    main()
