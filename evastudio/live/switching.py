"""Making a switch between policies: its conditions as text, or learned from a marked session."""

from __future__ import annotations

import shlex
import time
from collections.abc import Callable, Sequence
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import numpy as np

from evastudio.demonstrations.records import SessionRecord
from evastudio.demonstrations.store import Store
from evastudio.errors import ConflictError, InvalidInputError
from evastudio.learning.catalog import checked_policy_name, list_policies
from evastudio.learning.cleaning import Progress, silent
from evastudio.learning.switch import SUFFIX, Entry, Switch, save_switch
from evastudio.learning.switching import LearnedSwitch, MarkedTakes, learn_switch
from evastudio.live.demonstrating import check_session
from evastudio.live.headless import make_scene
from evastudio.live.piloting import load_switchboard, scene_of
from evastudio.pilots.marking import mark_field
from evastudio.workspace import Workspace
from evastudio.world.cast import of_lead
from evastudio.world.conditions import SECONDS, parse_condition, read
from evastudio.world.loading import find_scene
from evastudio.world.scene import Scene

LEARNED = "learned:"
"""What a condition begins with that is to be learned; the name of a session follows."""


def switch(
    workspace: Workspace,
    name: str,
    entries: Sequence[tuple[str, str | None]],
    *,
    perception: str | None = None,
    out: str | Path | None = None,
    clock: Callable[[], float] = time.time,
    progress: Progress = silent,
) -> dict[str, Any]:
    """Write a switch between policies as `name` into the workspace's, or to the file `out`.

    `entries` are policies, each with the condition under which it acts, the first that holds
    first; the last has None. Conditions are text as in `evastudio.world.conditions`, or
    `learned:SESSION` for what the marks in that session's takes have in common: signs of the scene,
    the time, and what `perception` shows. Raises NotFoundError, InvalidInputError, ConflictError.
    """
    found = list_policies(workspace.policy_folders).get(checked_policy_name(name))
    if found is not None and found.switch is None and out is None:
        raise ConflictError(f"There is a policy {name!r}; give the switch another name.")
    scene = make_scene(workspace, scene_of(workspace, [policy for policy, _ in entries]))
    made: list[Entry] = []
    told: list[str] = []
    steps: list[str] = []
    for number, (policy, text) in enumerate(entries):
        if text is None or not text.startswith(LEARNED):
            made.append(Entry(policy, None if text is None else parse_condition(text, scene)))
            continue

        def share(done: float, doing: str, number: int = number) -> None:
            progress((number + done) / len(entries), doing)

        with Store(workspace.ready().store_url) as store:
            session = store.session(text.removeprefix(LEARNED))
            learned = _learn(workspace, store, session, scene, perception, share)
        made.append(Entry(policy, learned.condition, learned.to_json()))
        told.append(learned.sentence(scene.dt_s))
        steps += [session.made_by] if session.made_by and session.made_by not in steps else []
    path = workspace.policies / (name + SUFFIX) if out is None else Path(out)
    if not path.name.endswith(SUFFIX):
        raise InvalidInputError(f"The file is {str(path)!r}; a switch's ends in {SUFFIX}.")
    words = [policy if text is None else _said(policy, text) for policy, text in entries]
    words += ["--perception", perception] if perception is not None else []
    words += ["--out", path.name] if out is not None else []
    steps.append(shlex.join(["evastudio", "switch", name, *words]))
    board = Switch(
        tuple(made),
        {"name": scene.name, "version": scene.version},
        " && ".join(steps),
        datetime.fromtimestamp(clock(), UTC).isoformat(timespec="seconds"),
    )
    load_switchboard(workspace, board, scene, name)  # refuses what could not play
    save_switch(board, path)
    progress(1.0, "Saved")
    report = [board.words(scene), *told]
    return {"policy": name, "file": str(path), "scene": scene.name, "report": report}


def parse_entry(text: str) -> tuple[str, str | None]:
    """A policy and the text of its condition: 'crowd-fleeing when event:impact'."""
    for word in (" when ", " once "):
        policy, found, condition = text.partition(word)
        if found:
            condition = condition.strip()
            return policy.strip(), f"once {condition}" if word == " once " else condition
    return text.strip(), None


def _said(policy: str, text: str) -> str:
    return f"{policy} {text}" if text.startswith("once ") else f"{policy} when {text}"


def _learn(
    workspace: Workspace,
    store: Store,
    session: SessionRecord,
    scene: Scene,
    perception: str | None,
    progress: Progress,
) -> LearnedSwitch:
    check_session(session, scene)
    return learn_switch(marked_takes(workspace, store, session, perception), progress)


def marked_takes(
    workspace: Workspace, store: Store, session: SessionRecord, perception: str | None = None
) -> MarkedTakes:
    """What could be read at every moment of the kept takes of a session, and its marks.

    Raises InvalidInputError where no take is kept, ConflictError where nothing can be marked.
    """
    kind = find_scene(session.scene, workspace.scene_folders)
    place = kind()
    view = place.perception(perception)
    names = [sign.name for sign in place.signs] + [SECONDS.name]
    names += [f"{view.name}.{field.name}" for field in view.state.fields]
    mark = mark_field(place)
    given = (place.action.low[mark] + place.action.high[mark]) / 2
    readings, marks = [], []
    takes = [take for take in store.takes(session.id) if take.pairs]
    for take, data in zip(takes, store.load_takes([take.id for take in takes]), strict=True):
        seconds = np.arange(float(len(data.actions))) * place.dt_s
        told = read(kind(**take.options), data.snapshots, seconds, names)
        readings.append(np.stack([of_lead(data.snapshots, told[name]) for name in names], axis=1))
        marks.append(of_lead(data.snapshots, data.actions)[:, mark] > given)
    if not marks:
        raise InvalidInputError(
            f"Session {session.name!r} has no takes. Record some, and mark a moment in each."
        )
    lengths = np.array([len(take) for take in marks], dtype=np.int64)
    return MarkedTakes(tuple(names), np.concatenate(readings), lengths, np.concatenate(marks))
