"""Evaluations by name: the same worlds for every policy, kept in the store, and made again."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

from evastudio.demonstrations.store import Store
from evastudio.errors import InvalidInputError
from evastudio.evaluation import archive
from evastudio.evaluation import pictures as drawing
from evastudio.evaluation.cluster import on_cluster
from evastudio.evaluation.evaluate import Shown
from evastudio.evaluation.evaluate import evaluate as evaluate_pilots
from evastudio.evaluation.results import Comparison
from evastudio.evaluation.versions import versions
from evastudio.evaluation.words import in_words
from evastudio.learning.cleaning import Progress, silent
from evastudio.learning.compiled import ensure_compiled
from evastudio.live.headless import make_scene
from evastudio.live.likening import shown_in
from evastudio.live.picturing import picture
from evastudio.live.piloting import fingerprint, fitted_anew, load_pilot, scene_of
from evastudio.workspace import Workspace
from evastudio.world.scene import Scene


def evaluate(
    workspace: Workspace,
    policies: Sequence[str],
    *,
    scene: str | None = None,
    worlds: int = 100,
    seed: int = 0,
    options: Mapping[str, float] | None = None,
    like: str | None = None,
    like_session: int | str | None = None,
    jobs: int = 1,
    cluster: str | None = None,
    pictures: str | Path | None = None,
    clock: Callable[[], float] = time.time,
    progress: Progress = silent,
) -> dict[str, Any]:
    """Fly every policy (or scripted pilot) through the same `worlds` new worlds.

    The scene is the first policy's unless it is given. `like` is the pilot, one of them, that the
    others should move like, `like_session` a session whose kept takes they should. The result is
    kept in the store, as `evaluation`. It is flown in `jobs` processes of this machine, or on the
    Dask cluster at the address `cluster`; the result is the same. Where a folder for `pictures` is
    named they are drawn into it.
    """
    if pictures is not None:
        drawing.ready()
    if not policies:
        raise InvalidInputError("No policy was given; name at least one to evaluate.")
    place = make_scene(workspace, scene or scene_of(workspace, policies), options)
    model: str | Shown | None = like
    kept: dict[str, Any] | None = None
    if like_session is not None:
        if like is not None:
            raise InvalidInputError(
                f"They cannot be to move both like {like!r} and like session {like_session!r}; "
                "choose one."
            )
        model, kept = shown_in(workspace, like_session, place)
    with on_cluster(cluster) as everywhere:
        many = jobs if cluster is None else everywhere
        compared = _compare(workspace, place, policies, worlds, seed, model, many, progress)
    asked = {
        "policies": {name: fingerprint(workspace, name) for name in policies},
        "scene": place.name,
        "options": dict(place.values),
        "worlds": worlds,
        "seed": seed,
        "like": like,
        "like_session": kept,
    }
    with Store(workspace.ready().store_url) as store:
        number = archive.save_evaluation(store, compared, asked, clock())
    told = {"evaluation": number, **_told(compared)}
    if pictures is not None:
        made = drawing.save_pictures(picture(workspace, number).figures, Path(pictures))
        told["pictures"] = [str(path) for path in made]
    return told


def evaluations(workspace: Workspace, scene: str | None = None) -> list[dict[str, Any]]:
    """Every evaluation kept, newest first, without its worlds."""
    with Store(workspace.ready().store_url) as store:
        return [asdict(record) for record in archive.evaluations(store, scene)]


def repeat_evaluation(
    workspace: Workspace, number: int, *, jobs: int = 1, progress: Progress = silent
) -> dict[str, Any]:
    """Make a stored evaluation again from what it recorded; what differs, bit for bit.

    `changed` lists what is not as it was (policies, versions), which may be why. Nothing is
    stored. Raises NotFoundError for an evaluation, scene or policy that is gone.
    """
    with Store(workspace.ready().store_url) as store:
        record, before = archive.find_evaluation(store, number)
    asked = record.asked
    place = make_scene(workspace, record.scene, asked["options"])
    names = list(asked["policies"])
    like: str | Shown | None = asked["like"]
    kept = asked.get("like_session")
    if kept is not None:
        like, _ = shown_in(workspace, kept["id"], place, kept["takes"])
    after = _compare(workspace, place, names, asked["worlds"], asked["seed"], like, jobs, progress)
    changed = [f"policy {name}" for name in fitted_anew(workspace, asked["policies"])]
    now = {**versions(), "scene": str(place.version)}
    then = {**record.versions, "scene": str(before.scene["version"])}
    changed += [
        f"{name} {then.get(name)}, now {now[name]}" for name in now if now[name] != then.get(name)
    ]
    differs = archive.differing(before, after)
    return {"evaluation": number, "same": not differs, "differs": differs, "changed": changed}


def _compare(
    workspace: Workspace,
    place: Scene,
    policies: Sequence[str],
    worlds: int,
    seed: int,
    like: str | Shown | None,
    jobs: int,
    progress: Progress,
) -> Comparison:
    ensure_compiled()  # figures must not depend on what was compiled before
    pilots = {name: load_pilot(workspace, name, place) for name in policies}
    return evaluate_pilots(
        place, pilots, worlds=worlds, seed=seed, like=like, n_jobs=jobs, progress=progress
    )


def _told(compared: Comparison) -> dict[str, Any]:
    told = compared.to_json()
    told["says"] = in_words(told)
    told["policies"] = told.pop("pilots")
    return told
