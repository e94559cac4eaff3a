"""What the page's buttons do, as functions: record, clean, fit, evaluate.

The command line, the jobs behind the page and `import evastudio` all call these.
"""

from __future__ import annotations

import json
import shlex
import time
from collections import Counter
from collections.abc import Callable, Mapping
from dataclasses import asdict, replace
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from evastudio.demonstrations.recorder import Recorder
from evastudio.demonstrations.store import Store
from evastudio.errors import InvalidInputError, StorageError, not_found
from evastudio.learning.catalog import (
    checked_policy_name,
    policy_name_from,
)
from evastudio.learning.cleaning import N_NEIGHBORS, Progress, clean_pairs, silent
from evastudio.learning.delay import Asked
from evastudio.learning.fitting import fit_policy
from evastudio.learning.policy import Policy, find_learner
from evastudio.learning.policy_files import SUFFIX, save_policy
from evastudio.learning.tuning import AUTO
from evastudio.live.clips import dress
from evastudio.live.free_names import free_file
from evastudio.live.in_short import in_short
from evastudio.live.missing import as_judged, missing_words
from evastudio.live.perceiving import see_session, unmarked
from evastudio.live.tuning import tune_session
from evastudio.pilots.lead import LeadPilot
from evastudio.pilots.marking import MarkingPilot
from evastudio.pilots.scripted import find_pilot
from evastudio.workspace import Workspace
from evastudio.world.cast import of_lead
from evastudio.world.conditions import parse_condition
from evastudio.world.loading import find_scene, find_scenes
from evastudio.world.rollout import roll_out
from evastudio.world.scene import Scene, world_seeds
from evastudio.world.snapshot import Snapshot
from evastudio.world.spaces import Array

MAX_MINUTES = 10_000.0
TUNING_SHARE = 0.8
"""Of the work of a fit whose settings are chosen first."""


def scenes(workspace: Workspace) -> list[type[Scene]]:
    """Every scene at hand."""
    return list(find_scenes(workspace.scene_folders).values())


def make_scene(
    workspace: Workspace, name: str, options: Mapping[str, float] | None = None
) -> Scene:
    """A scene by name, with `options`. Raises NotFoundError and InvalidInputError."""
    kind = find_scene(name, workspace.scene_folders)
    if options and "self" in options:  # Python would take it for the scene itself
        raise not_found(
            "option", "self", [option.name for option in kind.options], f"of scene {name!r}"
        )
    scene = kind(**(options or {}))
    dress(scene, workspace)
    return scene


def record(
    workspace: Workspace,
    scene: str,
    pilot: str = "scripted:careful",
    minutes: float = 8.0,
    seed: int = 0,
    *,
    options: Mapping[str, float] | None = None,
    session: str | None = None,
    mark: str | None = None,
    clock: Callable[[], float] = time.time,
    progress: Progress = silent,
) -> dict[str, Any]:
    """Let a scripted pilot demonstrate for `minutes` into a new session.

    World i has the i-th seed that follows from `seed`; the last take is cut when the time is up.
    The pilot marks the moments when the condition `mark`, text as in `evastudio.world.conditions`,
    begins or ceases to hold.
    """
    if not 0.0 < minutes <= MAX_MINUTES:
        raise InvalidInputError(
            f"The time is {minutes} minutes; it must be more than 0 and at most {MAX_MINUTES:g}."
        )
    place = make_scene(workspace, scene, options)
    leading = find_pilot(pilot)
    if mark is not None:
        leading = MarkingPilot(leading, parse_condition(mark, place))
    actor = LeadPilot(leading)
    left = round(minutes * 60.0 / place.dt_s)
    total = left
    outcomes: Counter[str] = Counter()
    takes = 0
    perception = place.perception()
    with Store(workspace.ready().store_url) as store:
        name = session or f"{pilot} {seed}"
        command = command_line(
            "record",
            scene,
            pilot=pilot,
            minutes=minutes,
            seed=seed,
            options=options,
            session=name,
            mark=mark,
        )
        number = store.create_session(place, name, pilot, clock(), command)
        recorder = Recorder(store, number, folders=workspace.unsaved)

        def watch(_: NDArray[np.int64], snapshot: Snapshot, actions: Array) -> None:
            seen = of_lead(snapshot, perception.perceive(snapshot).states)
            recorder.add(seen, actions, snapshot)

        while left > 0:
            world = world_seeds(seed, takes + 1)[-1]
            recorder.begin(place, place.worlds([world]), world, pilot, clock())
            result = roll_out(place, actor, [world], max_steps=left, watcher=watch)
            outcome = place.outcomes[int(result.outcomes[0])]
            cut = outcome == place.outcomes[0]
            recorder.end(None if cut else outcome, clock())
            outcomes["cut" if cut else outcome] += 1
            takes += 1
            left -= int(result.steps[0])
            progress(1.0 - left / total, f"{takes} takes")
        recorder.close(clock())
        return {**written(recorder, store), "outcomes": dict(outcomes)}


def written(recorder: Recorder, store: Store) -> dict[str, Any]:
    """What came of the session that a closed `recorder` wrote to.

    Raises StorageError where something is missing.
    """
    if recorder.problem is not None:
        raise StorageError(recorder.problem)
    made = store.session(recorder.session)
    return {
        "session": made.id,
        "name": made.name,
        "scene": made.scene,
        "demonstrator": made.demonstrator,
        "takes": made.takes_kept,
        "pairs": made.pairs,
        "seconds": made.seconds,
    }


def sessions(workspace: Workspace, scene: str | None = None) -> list[dict[str, Any]]:
    """The sessions of the store, newest first."""
    with Store(workspace.ready().store_url) as store:
        return [asdict(session) for session in store.sessions(scene)]


def fit(
    workspace: Workspace,
    session: int | str,
    *,
    learner: str | None = None,
    perception: str | None = None,
    settings: Mapping[str, Any] | None = None,
    delay: Asked = "auto",
    out: str | Path | None = None,
    name: str | None = None,
    beside: bool = False,
    clock: Callable[[], float] = time.time,
    progress: Progress = silent,
) -> dict[str, Any]:
    """Fit a policy to the kept pairs of a session, without those a cleaning marked.

    Without a `learner` it is the one that suits the scene's actions best; `auto` is the one that
    `tune` chooses, with its settings, and the policy then keeps the report. Actions are paired
    with what they answered a `delay` before: as estimated where held-out takes agree that it
    helps, "off", or so many seconds. The policy is written to the file `out`, or as `name` into
    the workspace's policies, where it replaces another of that name; `beside` it gets a number
    behind its name instead, and only one that is the same is replaced.
    """
    if learner == AUTO and settings:
        raise InvalidInputError(
            f"Settings were given ({', '.join(settings)}) and are to be chosen too. Name a learner "
            f"for your settings, or leave them to {AUTO!r}."
        )
    with Store(workspace.ready().store_url) as store:
        chosen = store.session(session)
        progress(0.0, "Reading the takes")
        (seen,) = see_session(workspace, store, chosen, [perception])
        marks = store.marks(chosen.id)
        verdicts = store.verdicts(chosen.id)
        identity = store.identity
    scene = seen.scene
    if learner != AUTO:
        learner = find_learner(learner, scene.chosen(scene.perception(perception)))
    late = seen.delay(delay)
    pairs = seen.pairs(late.steps)
    pairs = pairs.keep(unmarked(pairs, marks))
    if name is None:
        name = policy_name_from(f"{chosen.name} {learner}")
    path = (
        Path(out) if out is not None else workspace.policies / (checked_policy_name(name) + SUFFIX)
    )
    cleaning = None if chosen.cleaning is None else dict(chosen.cleaning.settings)
    made_by = [chosen.made_by] if chosen.made_by else []
    if cleaning is not None and "threshold" in cleaning:  # not of single pairs by hand alone
        asked = {name: cleaning[name] for name in ("perception", "neighbors", "threshold")}
        asked["delay"] = _unless_auto(cleaning.get("delay", "off"))
        made_by.append(command_line("clean", chosen.name, **asked))
    flags = {
        "learner": learner,
        "perception": perception,
        "set": settings,
        "delay": _unless_auto(delay),
    }
    tuning = found = None
    if learner == AUTO:
        tuning = tune_session(
            workspace,
            chosen,
            perception=perception,
            delay=delay,
            progress=lambda share, doing: progress(TUNING_SHARE * share, doing),
        )
        learner, settings = tuning.chosen.learner, tuning.chosen.settings
        if cleaning is None and tuning.chosen.threshold is not None:
            found = clean_pairs(pairs, scene, perception, threshold=tuning.chosen.threshold)
            found = as_judged(found, pairs, verdicts)
            cleaning = {"neighbors": N_NEIGHBORS, **found.report()}
    findings = [finding for finding in seen.findings(pairs) if finding.found]
    missing = missing_words(workspace, chosen, seen, late.steps, verdicts)
    told = [*missing, *(finding.sentence for finding in findings)]
    begins = 0.2 if tuning is None else TUNING_SHARE
    policy = fit_policy(
        pairs,
        scene,
        perception,
        learner,
        settings,
        cleaning=found,
        session=chosen.id,
        takes=[take.take for take in seen.takes],
        created=datetime.fromtimestamp(clock(), UTC).isoformat(timespec="seconds"),
        progress=lambda share, doing: progress(begins + (0.95 - begins) * share, doing),
    )
    policy = replace(
        policy,
        cleaning=cleaning,
        extra={
            "store": identity,
            "session_name": chosen.name,
            "demonstrator": chosen.demonstrator,
            "pairs_before_cleaning": seen.recorded,
            "delay": late.report(),
            "findings": told,
            "in_short": [*missing, *map(in_short, findings)],
            "cleaning_id": None if chosen.cleaning is None else chosen.cleaning.id,
            **({} if tuning is None else {"tuning": tuning.to_json()}),
        },
    )

    def called(path: Path) -> Policy:
        line = command_line("fit", chosen.name, **flags, out=path.name)
        return replace(policy, made_by=" && ".join([*made_by, line]))

    if beside:
        path = free_file(path, called, workspace.policy_folders)
    save_policy(called(path), path)
    progress(1.0, "Saved")
    return {
        "policy": path.name.removesuffix(SUFFIX),
        "file": str(path),
        "session": chosen.id,
        "learner": learner,
        "perception": policy.perception,
        "pairs": policy.pairs,
        "pairs_before_cleaning": seen.recorded,
        "settings": policy.settings,
        "delay_s": late.steps * scene.dt_s,
        "report": [late.sentence(), *told, *(() if tuning is None else tuning.sentences)],
        "bytes": path.stat().st_size,
    }


def _unless_auto(delay: Asked) -> Asked | None:
    return None if delay == "auto" else delay


def command_line(name: str, *targets: str, **flags: Any) -> str:
    """The command line that does this again. Flags that are None are left out."""
    words = ["evastudio", name, *targets]
    for flag, value in flags.items():
        if isinstance(value, Mapping):
            single = "option" if flag == "options" else flag
            for key, part in value.items():
                words += [f"--{single}", f"{key}={json.dumps(part)}"]
        elif value is not None:
            words += [
                f"--{flag.replace('_', '-')}",
                repr(value) if isinstance(value, float) else str(value),
            ]
    return shlex.join(words)
