"""Pictures of an evaluation: drawn by a job, kept in the workspace, and handed out as they are."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from evastudio.demonstrations.store import Store
from evastudio.errors import StorageError, not_found
from evastudio.evaluation import archive
from evastudio.evaluation import pictures as drawing
from evastudio.evaluation.archive import EvaluationRecord
from evastudio.evaluation.blaming import blaming
from evastudio.evaluation.evaluate import MAX_STEPS
from evastudio.evaluation.flight import Flight, Logbook
from evastudio.evaluation.pictures import Curve, Rate
from evastudio.evaluation.results import SUCCESS, Comparison
from evastudio.learning.cleaning import Progress, silent
from evastudio.live.headless import make_scene
from evastudio.live.piloting import fitted_anew, load_pilot
from evastudio.pilots.policy import PolicyPilot
from evastudio.workspace import Workspace
from evastudio.world.rollout import Pilot, roll_out
from evastudio.world.scene import Scene, world_seeds
from evastudio.writing import write_whole

if TYPE_CHECKING:
    from matplotlib.figure import Figure

PICTURED = 4
"""Worlds that the pictures of an evaluation are drawn from."""
TITLES = {
    "outcomes": "How many worlds ended well",
    "crossing": "How many ended well where worlds were harder or easier",
    "paths": "The ways through the first world, from above",
    "paths-in-space": "The same ways in space",
    "actions": "How often each action was taken",
    "learning": "How the search for a policy went",
}
"""What each picture shows, for people; in the order in which they are shown."""
_LIST = "drawn.json"


@dataclass(frozen=True)
class Drawn:
    """What was drawn of an evaluation, by name, and what could not be."""

    figures: Mapping[str, Figure]
    beside: tuple[int, ...]
    """The evaluations in the crossing curves, from the least value on; none without curves."""
    left_out: str | None
    """Why something is missing, or None."""


@dataclass(frozen=True)
class Kept:
    """The pictures of an evaluation that are kept."""

    names: tuple[str, ...]
    left_out: str | None
    """Why something is missing, or None."""
    whole: bool
    """Whether they show what is known now; drawing makes it so."""


def picture(workspace: Workspace, number: int, progress: Progress = silent) -> Drawn:
    """What a stored evaluation found. Its first PICTURED worlds are flown again for it.

    Where a policy's file is another now, what needs flying is left out. Raises NotFoundError.
    """
    with Store(workspace.store_url) as store:
        record, compared = archive.find_evaluation(store, number)
        others = archive.beside(record, archive.evaluations(store, record.scene))
    scene = make_scene(workspace, record.scene, record.asked["options"])
    figures = {"outcomes": drawing.success_rates(compared)}
    if others is not None:
        figures["crossing"] = _crossing(scene, *others)
    left_out = _cannot_fly(workspace, scene, record)
    if left_out is None:
        names = record.asked["policies"]
        pilots = {name: load_pilot(workspace, name, scene) for name in names}
        figures |= flown(scene, pilots, compared, progress) | _searched(pilots)
    return Drawn(
        {name: figures[name] for name in TITLES if name in figures}, _numbers(others), left_out
    )


def draw_pictures(
    workspace: Workspace, evaluation: int, progress: Progress = silent
) -> dict[str, Any]:
    """Draw the pictures of a stored evaluation and keep them in the workspace: a job.

    Raises NotFoundError, ConflictError where matplotlib is not installed, StorageError where they
    cannot be written.
    """
    drawing.ready()
    drawn = picture(workspace, evaluation, progress)
    with Store(workspace.store_url) as store:
        folder = _folder(workspace, archive.find_record(store, evaluation))
    progress(0.9, "Drawing")
    drawing.save_pictures(drawn.figures, folder)
    told = {"names": list(drawn.figures), "beside": drawn.beside, "left_out": drawn.left_out}
    write_whole(folder / _LIST, json.dumps(told).encode())
    return {"evaluation": evaluation, "pictures": told["names"], "left_out": drawn.left_out}


def kept_pictures(workspace: Workspace, store: Store, evaluation: int) -> Kept:
    """The pictures of a stored evaluation that have been drawn. Raises NotFoundError."""
    record = archive.find_record(store, evaluation)
    told = _told(_folder(workspace, record))
    if told is None:
        return Kept((), None, False)
    others = archive.beside(record, archive.evaluations(store, record.scene))
    return Kept(tuple(told["names"]), told["left_out"], tuple(told["beside"]) == _numbers(others))


def picture_file(workspace: Workspace, store: Store, evaluation: int, name: str) -> Path:
    """The file called `name`, like 'paths.svg'. Raises NotFoundError where it is not drawn."""
    folder = _folder(workspace, archive.find_record(store, evaluation))
    told = _told(folder) or {"names": []}
    known = [f"{one}.{form}" for one in told["names"] for form in drawing.FORMS]
    if name not in known:
        raise not_found("picture", name, known, f"of evaluation {evaluation}")
    return folder / name


def flown(
    scene: Scene, pilots: Mapping[str, Pilot], compared: Comparison, progress: Progress = silent
) -> dict[str, Figure]:
    """Pictures of what `pilots` do in the first PICTURED worlds of `compared`, by name."""
    seeds = world_seeds(compared.seed, min(PICTURED, compared.worlds))
    flights: dict[str, list[Flight]] = {}
    for done, (name, pilot) in enumerate(pilots.items()):
        progress(0.8 * done / len(pilots), f"{name}: once more through the first worlds")
        log = Logbook(scene)
        with blaming(scene, name):
            roll_out(scene, pilot, seeds, max_steps=MAX_STEPS, watcher=log)
            flights[name] = log.flights()
    first = {name: own[0] for name, own in flights.items()}
    ended = [bool(one.succeeded[0]) for one in compared.pilots.values()]
    figures = {
        "paths": drawing.paths_from_above(scene, first, ended),
        "actions": drawing.action_histograms(scene, flights),
    }
    if scene.whereabouts(next(iter(first.values())).moments).shape[1] == 3:
        figures["paths-in-space"] = drawing.paths_in_space(scene, first, ended)
    return figures


def _searched(pilots: Mapping[str, Pilot]) -> dict[str, Figure]:
    curves = {}
    for name, pilot in pilots.items():
        search = pilot.policy.extra.get("pegasus") if isinstance(pilot, PolicyPilot) else None
        if search is not None:
            rounds = search["curve"]
            curves[name] = Curve([one["cpu_s"] for one in rounds], [one["score"] for one in rounds])
    if not curves:
        return {}
    title = "PEGASUS: score of the best network so far"
    return {"learning": drawing.learning_curves(curves, "CPU time, s", "score", title)}


def _crossing(scene: Scene, option: str, records: Mapping[float, EvaluationRecord]) -> Figure:
    rates: dict[str, dict[float, Rate]] = {}
    for value, record in records.items():
        for name, one in record.result["pilots"].items():
            rates.setdefault(name, {})[value] = (one[SUCCESS], tuple(one["interval"]))
    label = next(known.label for known in scene.options if known.name == option)
    return drawing.crossing_curves(rates, label)


def _cannot_fly(workspace: Workspace, scene: Scene, record: EvaluationRecord) -> str | None:
    """Why what was flown then cannot be flown again, or None."""
    if record.result["scene"]["version"] != scene.version:
        return "Ways and actions are not drawn: the scene has changed since this evaluation."
    changed = fitted_anew(workspace, record.asked["policies"])
    if changed:
        return f"Ways and actions are not drawn: {', '.join(changed)} changed since."
    return None


def _numbers(others: tuple[str, Mapping[float, EvaluationRecord]] | None) -> tuple[int, ...]:
    return () if others is None else tuple(one.id for one in others[1].values())


def _folder(workspace: Workspace, record: EvaluationRecord) -> Path:
    return workspace.pictures / f"evaluation-{record.id}-{record.mark[:16]}"


def _told(folder: Path) -> dict[str, Any] | None:
    """What the list in `folder` says, or None where nothing is drawn yet."""
    try:
        told: dict[str, Any] = json.loads((folder / _LIST).read_bytes())
    except FileNotFoundError:
        return None
    except (OSError, ValueError) as error:
        raise StorageError(
            f"The list of pictures in {str(folder)!r} cannot be read ({error}). Delete the folder; "
            "they are drawn again."
        ) from None
    return told
