"""Nearest neighbours against scikit-learn, SciPy and pykdtree in one interleaved run.

    python benchmarks/neighbors.py            # all figures, and costs up to 10 million pairs
    python benchmarks/neighbors.py --quick    # small sets, once, to see that it runs

Pairs and queries are those of `steering`, queries from other worlds: 8 components, 2 actions, 5
neighbours weighing one over their distance. Everybody makes the same decision: standardise,
search, average. Peers get float64, or float32 where that is faster, the leaf size that is best for
them here, one thread for one decision, and all processors for a batch. CPU and wall time, medians.
"""

from __future__ import annotations

import argparse
import multiprocessing
import os
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from pykdtree.kdtree import KDTree
from scipy.spatial import cKDTree
from sklearn.neighbors import KNeighborsRegressor, NearestNeighbors

from benchmarks.crossing import demonstrate, scene_at
from benchmarks.report import processor
from benchmarks.steering import steered
from benchmarks.svr import Row, timed
from evastudio.learning.compiled import ensure_compiled
from evastudio.learning.conflicts import ConflictEliminator
from evastudio.learning.fitting import fit_policy
from evastudio.learning.kernels.sharing import THREADS
from evastudio.learning.knn import KNNPolicy
from evastudio.learning.neighbors import Indices
from evastudio.learning.policy_files import save_policy
from evastudio.learning.scaling import Scaling
from evastudio.pilots.scripted import find_pilot
from evastudio.world.spaces import Array

K = 5
BATCH = 10_000
LEAF_SIZES = (8, 16, 32)
SETTLE_S = 0.1
"""Before each turn: threads of OpenMP go on spinning after their work, into the other's turn."""
SIZES = (10_000, 100_000, 1_000_000, 10_000_000)
BLOCK = 65_536
FIRST = """
import sys
import numpy as np
from evastudio.learning import load_policy
policy = load_policy(sys.argv[1])
policy.act_states(np.zeros((1, policy.state.size)))
import time
print(time.process_time())
"""
"""What a fresh process does to make its first decision."""


@dataclass(frozen=True)
class Cost:
    """What a number of pairs costs, in a process of its own."""

    pairs: int
    build_s: float
    """Fitting a k-NN policy: standardisation and tree."""
    decision_s: float
    """One decision."""
    batch_s: float
    """One decision of a batch."""
    clean_s: float
    """Marking the conflicts among all pairs."""
    peak_mb: float
    """The most memory the process held, with the pairs themselves."""


def averaged(distances: Array, actions: Array) -> Array:
    """Mean of `actions` (rows, k, m) by one over the distances (rows, k)."""
    weights = 1.0 / np.maximum(distances, 1e-12)
    weights /= weights.sum(axis=1, keepdims=True)
    return np.asarray(np.einsum("rk,rkm->rm", weights, actions))


def fastest(candidates: Sequence[Any], ask: Callable[[Any], object]) -> Any:
    """The candidate that `ask` is done with soonest."""
    spent = [min(timed(lambda c=c: ask(c))[1] for _ in range(3)) for c in candidates]
    return candidates[int(np.argmin(spent))]


def compare(
    what: str, peer: str, ours: Any, theirs: Any, counts: tuple[int, int], repeats: int,
    at_least: float, note: str = "",
) -> Row:  # fmt: skip
    """Both in turn; each is called with the number of the repetition and does `counts` things."""
    spent: tuple[list[Any], list[Any]] = ([], [])
    for repeat in range(repeats):
        for side, work, count in zip(spent, (ours, theirs), counts, strict=True):
            time.sleep(SETTLE_S)
            cpu, wall, _ = timed(lambda work=work, repeat=repeat: work(repeat))
            side.append((cpu / count, wall / count))
    (a, b), (c, d) = (zip(*side, strict=True) for side in spent)
    return Row(what, peer, a, c, b, d, at_least, note)


def deciding(pairs: int, repeats: int) -> list[Row]:
    """One state at a time, each another one: `KNNPolicy.decide`, as the studio asks it."""
    states, actions = steered(pairs, 1)
    queries = steered(BATCH, 2)[0]
    ones = [queries[row : row + 1] for row in range(0, BATCH, 5)]
    learner = KNNPolicy(K, "distance").fit(states, actions)
    scaling = Scaling.of(states)
    scaled = scaling.apply(states)

    def through_scipy(tree: cKDTree, one: Array) -> Array:
        distances, found = tree.query(scaling.apply(one), k=K)
        return averaged(distances, actions[found])

    few = ones[:200]
    tree = fastest(
        [cKDTree(scaled, leafsize) for leafsize in LEAF_SIZES],
        lambda tree: [through_scipy(tree, one) for one in few],
    )
    kinds = [("kd_tree", size) for size in LEAF_SIZES] + [("brute", 30)] * (pairs < 20_000)
    regressor = fastest(
        [
            KNeighborsRegressor(K, weights="distance", algorithm=kind, leaf_size=size).fit(
                scaled, actions
            )
            for kind, size in kinds
        ],
        lambda model: [model.predict(scaling.apply(one)) for one in few[:50]],
    )
    apart = max(np.abs(learner.decide(one) - through_scipy(tree, one)).max() for one in few)

    def ours(repeat: int) -> None:
        for one in ones:
            learner.decide(one)

    rows = []
    for peer, at_least, ask, count in (
        ("sklearn KNeighborsRegressor", 150.0 if pairs < 20_000 else 120.0, None, 100),
        ("SciPy cKDTree and a weighted mean", 20.0 if pairs < 20_000 else 1.0, tree, 500),
    ):

        def theirs(repeat: int, ask: Any = ask, count: int = count) -> None:
            for one in ones[:count]:
                if ask is None:
                    regressor.predict(scaling.apply(one))
                else:
                    through_scipy(ask, one)

        note = f"answers within {apart:.0e}" if ask is not None else regressor.algorithm
        rows.append(
            compare(
                f"one decision, {pairs} pairs",
                peer,
                ours,
                theirs,
                (len(ones), count),
                repeats,
                at_least,
                note,
            )
        )
    return rows


def batches(pairs: int, repeats: int) -> list[Row]:
    """Ten thousand states in one call, on all processors."""
    states, actions = steered(pairs, 1)
    queries = steered(BATCH, 2)[0]
    learner = KNNPolicy(K, "distance").fit(states, actions)
    scaling = Scaling.of(states)
    scaled = scaling.apply(states)

    def through_scipy(tree_and_workers: Any) -> Array:
        tree, workers = tree_and_workers
        distances, found = tree.query(scaling.apply(queries), k=K, workers=workers)
        return averaged(distances, actions[found])

    def through_pykdtree(tree: KDTree) -> Array:
        asked = scaling.apply(queries).astype(tree.data_pts.dtype)
        distances, found = tree.query(asked, k=K)
        return averaged(distances, actions[found])

    scipy = fastest(
        [(cKDTree(scaled, size), workers) for size in LEAF_SIZES for workers in (1, -1)],
        through_scipy,
    )
    other = fastest(
        [KDTree(scaled.astype(t), size) for size in LEAF_SIZES for t in (np.float32, np.float64)],
        through_pykdtree,
    )
    learner.decide(queries)
    return [
        compare(
            f"batch of {BATCH}, {pairs} pairs",
            peer,
            lambda _: learner.decide(queries),
            theirs,
            (BATCH, BATCH),
            3 * repeats,
            3.5,
        )
        for peer, theirs in (
            (f"SciPy cKDTree, workers={scipy[1]}", lambda _: through_scipy(scipy)),
            (f"pykdtree, {other.data_pts.dtype}", lambda _: through_pykdtree(other)),
        )
    ]


def medians_of(found: Indices, actions: Array) -> Array:
    """Deviations of `actions` (n, m) from the vector medians of those `found` (n, k) name."""
    deviations = np.empty(len(actions))
    for start in range(0, len(actions), BLOCK):
        near = actions[found[start : start + BLOCK]]
        between = np.sqrt(((near[:, :, None] - near[:, None]) ** 2).sum(axis=-1)).sum(axis=2)
        medians = near[np.arange(len(near)), between.argmin(axis=1)]
        apart = medians - actions[start : start + BLOCK]
        deviations[start : start + BLOCK] = np.sqrt((apart**2).sum(axis=1))
    return deviations


def marks_by_sklearn(states: Array, actions: Array) -> Array:
    scaled = Scaling.of(states).apply(states)
    model = NearestNeighbors(n_neighbors=K, algorithm="kd_tree", n_jobs=-1).fit(scaled)
    found = model.kneighbors(return_distance=False)
    return medians_of(found, actions / np.ptp(actions, axis=0)) > 0.1


def marks_by_pykdtree(states: Array, actions: Array) -> Array:
    scaled = Scaling.of(states).apply(states).astype(np.float32)
    found = KDTree(scaled).query(scaled, k=K + 1)[1].astype(np.int64)
    own = found == np.arange(len(scaled))[:, None]
    own[~own.any(axis=1), -1] = True  # of many at the same place
    found = found[~own].reshape(-1, K)
    return medians_of(found, actions / np.ptp(actions, axis=0)) > 0.1


def cleaning(pairs: int, peer: str, theirs: Any, repeats: int, at_least: float) -> Row:
    """All conflicts among the pairs, from arrays to marks."""
    states, actions = steered(pairs, 1)
    ours = ConflictEliminator(K, 0.1).fit(states, actions).conflict_mask_
    differ = int((ours != theirs(states, actions)).sum())
    return compare(
        f"cleaning {pairs} pairs", peer,
        lambda _: ConflictEliminator(K, 0.1).fit(states, actions),
        lambda _: theirs(states, actions),
        (1, 1), repeats, at_least, f"{differ} marks differ, {int(ours.sum())} marked",
    )  # fmt: skip


def apart(function: Callable[..., Any], *arguments: Any) -> Any:
    """The result of `function` in a fresh process, whose memory is its own."""
    with ProcessPoolExecutor(1, mp_context=multiprocessing.get_context("spawn")) as pool:
        return pool.submit(function, *arguments).result()


def peak_mb() -> float:
    """The most memory that this process has held."""
    status = Path("/proc/self/status").read_text()
    return int(status.partition("VmHWM:")[2].split()[0]) / 1000


def cleaning_memory(pairs: int) -> float:
    """MB that cleaning adds to what the process held before; run by `apart`."""
    states, actions = steered(1000, 1)
    ConflictEliminator(K, 0.1).fit(states, actions)
    states, actions = steered(pairs, 1)
    before = peak_mb()
    ConflictEliminator(K, 0.1).fit(states, actions)
    return peak_mb() - before


def cost(pairs: int) -> Cost:
    """What everything costs with that many pairs; run by `apart`."""
    KNNPolicy(K, "distance").fit(*steered(1000, 1)).decide(steered(1000, 2)[0])
    states, actions = steered(pairs, 1)
    queries = steered(BATCH, 2)[0]
    build, _, learner = timed(lambda: KNNPolicy(K, "distance").fit(states, actions))
    ones = [queries[row : row + 1] for row in range(0, BATCH, 5)]
    singles = [timed(lambda: [learner.decide(one) for one in ones])[0] for _ in range(3)]
    together = [timed(lambda: learner.decide(queries))[0] for _ in range(5)]
    clean = timed(lambda: ConflictEliminator(K, 0.1).fit(states, actions))[0]
    return Cost(
        pairs,
        build,
        statistics.median(singles) / len(ones),
        statistics.median(together) / BATCH,
        clean,
        peak_mb(),
    )


def first_decision(repeats: int) -> Sequence[float]:
    """CPU seconds of whole fresh processes that load a policy file and decide once."""
    scene = scene_at(4.0)
    pairs = demonstrate(scene, find_pilot("scripted:careful"), 3, 8.0)["paper"]
    policy = fit_policy(pairs, scene, "paper", "knn", {"k": K, "weights": "distance"})
    with tempfile.TemporaryDirectory() as folder:
        path = save_policy(policy, Path(folder) / "policy.safetensors")
        command = [sys.executable, "-c", FIRST, str(path)]
        return [
            float(subprocess.run(command, check=True, capture_output=True, text=True).stdout)
            for _ in range(repeats + 1)
        ][1:]


def measure(quick: bool = False) -> list[Row]:
    """Every figure beside its peers, peers and ours in turn."""
    ensure_compiled()
    repeats = 1 if quick else 5
    small, large, largest = (1000, 5000, 20_000) if quick else (6000, 100_000, 1_000_000)
    rows = [*deciding(small, repeats), *deciding(large, repeats)]
    rows += [*batches(small, repeats), *batches(large, repeats)]
    rows.append(cleaning(large, "sklearn NearestNeighbors", marks_by_sklearn, repeats, 8.0))
    rows.append(cleaning(largest, "pykdtree", marks_by_pykdtree, 1, 4.0))
    return rows


def curve(quick: bool = False) -> list[Cost]:
    """How costs grow, each size in a fresh process."""
    ensure_compiled()
    return [apart(cost, pairs) for pairs in (SIZES[:1] if quick else SIZES)]


def told(seconds: Sequence[float]) -> str:
    """The median, in a unit that reads well."""
    middle = statistics.median(seconds)
    return f"{middle:.2f} s" if middle >= 0.01 else f"{1e6 * middle:.2f} us"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="small sets, once")
    options = parser.parse_args()
    print(f"{processor()}, {os.cpu_count()} cores, {THREADS} threads, {time.strftime('%Y-%m-%d')}")
    for row in measure(options.quick):
        wall = statistics.median(row.peer_wall_s) / statistics.median(row.ours_wall_s)
        print(
            f"{row.what}: {told(row.ours_s)} CPU, {told(row.ours_wall_s)} wall; {row.peer}: "
            f"{told(row.peer_s)} CPU, {told(row.peer_wall_s)} wall; {row.ratio:.1f}x CPU, "
            f"{wall:.1f}x wall (at least {row.at_least:g}x); {row.note}",
            flush=True,
        )
    more = apart(cleaning_memory, 20_000 if options.quick else 1_000_000)
    print(f"Cleaning the largest adds {more:.0f} MB (at most 500)")
    print(f"First decision of a fresh process: {told(first_decision(3))} CPU (at most 2)")
    for one in curve(options.quick):
        print(
            f"{one.pairs} pairs: built in {1e6 * one.build_s / one.pairs:.2f} us a pair, a "
            f"decision {1e6 * one.decision_s:.2f} us, in a batch {1e6 * one.batch_s:.2f} us, "
            f"cleaned in {1e6 * one.clean_s / one.pairs:.2f} us a pair; at most "
            f"{one.peak_mb:.0f} MB",
            flush=True,
        )


if __name__ == "__main__":
    main()
