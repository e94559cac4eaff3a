"""Searching for a policy without demonstrations: PEGASUS, saved as any other policy."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from dataclasses import asdict, replace
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from evastudio.evaluation.cluster import on_cluster
from evastudio.learning.catalog import checked_policy_name
from evastudio.learning.cleaning import Progress, silent
from evastudio.learning.policy_files import SUFFIX, save_policy
from evastudio.live.headless import command_line, make_scene
from evastudio.pilots.pegasus import Pegasus, Round
from evastudio.workspace import Workspace


def search(
    workspace: Workspace,
    scene: str = "asteroids",
    settings: Pegasus | None = None,
    *,
    perception: str | None = None,
    options: Mapping[str, float] | None = None,
    out: str | Path | None = None,
    name: str | None = None,
    jobs: int = 1,
    cluster: str | None = None,
    clock: Callable[[], float] = time.time,
    progress: Progress = silent,
) -> dict[str, Any]:
    """The best policy that `settings` find for `scene`, written to `out`, or as `name`.

    The file keeps the settings and how the score rose; what is found follows from them. Networks
    are tried in `jobs` processes, or on the Dask cluster at the address `cluster`.
    """
    wanted = settings or Pegasus()
    place = make_scene(workspace, scene, options)
    ready = workspace.ready()
    path = (
        Path(out)
        if out is not None
        else ready.policies / (checked_policy_name(name or f"pegasus-{wanted.seed}") + SUFFIX)
    )
    curve: list[dict[str, float]] = []

    def watch(now: Round) -> None:
        curve.append({"score": now.score, "decisions": now.decisions, "cpu_s": round(now.cpu_s, 1)})
        progress(len(curve) / wanted.rounds, f"Best score so far {now.score:.3f}")

    with on_cluster(cluster) as everywhere:
        many = jobs if cluster is None else everywhere
        policy = wanted.search(place, perception, watch=watch, n_jobs=many)
    usual = asdict(Pegasus())
    changed = {key: value for key, value in asdict(wanted).items() if value != usual[key]}
    policy = replace(
        policy,
        made_by=command_line(
            "search",
            scene,
            perception=perception,
            options=options,
            **changed,
            out=path.name,
        ),
        created=datetime.fromtimestamp(clock(), UTC).isoformat(timespec="seconds"),
        extra={"pegasus": {**asdict(wanted), "curve": curve}},
    )
    save_policy(policy, path)
    return {
        "policy": path.name.removesuffix(SUFFIX),
        "file": str(path),
        "score": curve[-1]["score"],
        "decisions": curve[-1]["decisions"],
        "cpu_s": curve[-1]["cpu_s"],
        "bytes": path.stat().st_size,
    }
