"""The paper's tables from one call: demonstrate, measure, and write them with their pictures."""

from __future__ import annotations

import json
import platform
import tempfile
import time
from collections.abc import Callable
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any

from evastudio.demonstrations.pairs import Pairs
from evastudio.demonstrations.store import Store
from evastudio.evaluation import paper_tables
from evastudio.evaluation import pictures as drawing
from evastudio.evaluation.cluster import on_cluster
from evastudio.evaluation.paper import DEMONSTRATOR, PERCEPTION, QUICK, Extent, Measured, measure
from evastudio.evaluation.preferences import preferences
from evastudio.evaluation.studies import studies
from evastudio.evaluation.versions import processor, versions
from evastudio.learning.cleaning import Progress, silent
from evastudio.learning.compiled import ensure_compiled
from evastudio.live.headless import make_scene, record
from evastudio.live.perceiving import see_session
from evastudio.live.picturing import flown
from evastudio.workspace import Workspace
from evastudio.world.scene import Scene
from evastudio.writing import write_whole

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SCENE = "asteroids"
RECORDING = 0.05
MEASURING = 0.95
"""Shares of the work that are done once that is."""


def paper(
    workspace: Workspace,
    out: str | Path = "paper",
    *,
    quick: bool = False,
    extent: Extent | None = None,
    jobs: int = 1,
    cluster: str | None = None,
    clock: Callable[[], float] = time.time,
    progress: Progress = silent,
) -> dict[str, Any]:
    """Measure the paper's tables 1 and 2 here, and write them into the folder `out`.

    It gets `paper.md`, `paper.json` and pictures. `extent` says how much is measured, else
    `quick` chooses the one of a few minutes. The demonstrator is a program. The scene is the
    shipped one; of `workspace` only the studies and votes stored are read, for table 3. The fields
    are flown in `jobs` processes, or on the Dask cluster at the address `cluster`; outcomes are the
    same, times are those of the machines that did the work. Raises ConflictError without the
    extra `pictures`, or where CMA-ES is asked for without `pegasus`.
    """
    drawing.ready()
    chosen = extent or (QUICK if quick else Extent())
    with Store(workspace.ready().store_url) as store:
        people, liked = studies(store), preferences(store)
    ensure_compiled()  # no time may depend on what was compiled before
    with tempfile.TemporaryDirectory() as folder, on_cluster(cluster) as everywhere:
        own = Workspace(Path(folder))
        scenes = {density: _scene(own, chosen, density) for density in chosen.densities}
        pairs = _demonstrate(own, chosen, scenes[chosen.at], progress)
        found = measure(
            scenes,
            pairs,
            chosen,
            n_jobs=jobs if cluster is None else everywhere,
            progress=lambda share, doing: progress(
                RECORDING + (MEASURING - RECORDING) * share, doing
            ),
        )
    progress(MEASURING, "Drawing")
    place = Path(out)
    told = {
        "date": f"{datetime.fromtimestamp(clock(), UTC):%Y-%m-%d}",
        "machine": processor(),
        "versions": versions(),
        **paper_tables.to_json(found, people, liked),
    }
    made = (
        f"{told['machine']}, {told['date']}, Python {platform.python_version()}, evastudio "
        f"{versions()['evastudio']}; `evastudio paper{' --quick' if chosen == QUICK else ''}`."
    )
    text = paper_tables.to_markdown(found, people, liked, made)
    figures = draw(scenes[chosen.at], found)
    text += "".join(f"\n![{name.replace('-', ' ')}]({name}.svg)\n" for name in figures)
    files = [
        write_whole(place / "paper.md", text.encode()),
        write_whole(place / "paper.json", json.dumps(told, indent=2, allow_nan=False).encode()),
        *drawing.save_pictures(figures, place),
    ]
    progress(1.0, "Written")
    return {"files": [str(path) for path in files], **told}


def draw(scene: Scene, found: Measured) -> dict[str, Figure]:
    """The pictures of what was `found`, by name; `scene` is the one that was searched."""
    at = found.extent.at
    rates = {
        name: {
            density: (one.pilots[name].success_rate, one.pilots[name].interval)
            for density, one in found.compared.items()
        }
        for name in found.pilots
    }
    curves = {
        name: drawing.Curve(
            [one.cpu_s for one in search.rounds], [one.score for one in search.rounds]
        )
        for name, search in found.searches.items()
    }
    return {
        "crossing": drawing.crossing_curves(
            rates, "expected hits of a straight flight (NH)", "Fields crossed"
        ),
        "learning": drawing.learning_curves(
            curves, "CPU time, s", "score", "PEGASUS: score of the best network so far"
        ),
        **flown(scene, found.pilots, found.compared[at]),
    }


def _scene(workspace: Workspace, extent: Extent, density: float) -> Scene:
    options = {"density": density, "half_width": extent.half_width_m}
    return make_scene(workspace, SCENE, options)


def _demonstrate(workspace: Workspace, extent: Extent, scene: Scene, progress: Progress) -> Pairs:
    """What the scripted demonstrator does, recorded as the studio records it."""
    made = record(
        workspace,
        SCENE,
        DEMONSTRATOR,
        extent.pairs * scene.dt_s / 60.0,
        extent.seed,
        options=dict(scene.values),
        progress=lambda share, doing: progress(RECORDING * share, f"Demonstrating: {doing}"),
    )
    with Store(workspace.store_url) as store:
        (seen,) = see_session(workspace, store, store.session(made["session"]), [PERCEPTION])
    return seen.pairs()
