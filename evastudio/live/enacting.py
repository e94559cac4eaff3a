"""Takes that a program makes: it gives the actions, the studio steps the world and writes.

So a program's take replays as every other does: what is kept of it follows from its seed, its
scene and its actions, and nothing in it is claimed.
"""

from __future__ import annotations

import secrets
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from evastudio.demonstrations.resuming import Unfinished, resume_take, written_actions
from evastudio.demonstrations.store import Store
from evastudio.errors import ConflictError, InvalidInputError, StorageError
from evastudio.live.demonstrating import PROGRAM, check_session
from evastudio.live.headless import make_scene
from evastudio.workspace import Workspace
from evastudio.world.cast import for_all, of_lead
from evastudio.world.scene import Scene
from evastudio.world.snapshot import Snapshot, moments_of, stack
from evastudio.world.spaces import Array, finite_rows

MOST_STEPS = 4096
"""Steps that can be given at once."""
LONGEST = 100_000
"""Steps of one take."""
LIKE = 1e-6
"""States that a program saw are those of the world where they are this near."""


@dataclass(frozen=True)
class Standing:
    """How a program's take stands."""

    take: int
    pairs: int
    """Written so far; the next actions begin with this step."""
    accepted: int
    """Of the actions given last; fewer where the world ended before the others."""
    closed: bool
    """No more can be written: the world has ended, or the program closed the take."""
    outcome: str | None
    """How the world ended, as the scene says; None where it has not."""
    state: list[float]
    """What the character now perceives, under the take's perception."""


def begin_take(
    workspace: Workspace,
    store: Store,
    session: int,
    pilot: str,
    now: float,
    *,
    seed: int | None = None,
    options: Mapping[str, float] | None = None,
    perception: str | None = None,
) -> Standing:
    """A new take of a session, without pairs so far; a world of any `seed` where none is given.

    Raises NotFoundError, InvalidInputError for options, and ConflictError where the session is of
    another version of its scene.
    """
    record = store.session(session)
    scene = make_scene(workspace, record.scene, options)
    check_session(record, scene)
    view = scene.perception(perception)
    chosen = secrets.randbelow(2**53) if seed is None else seed
    start = scene.worlds([chosen])
    take = store.begin_take(session, scene, view.name, chosen, PROGRAM + pilot, start.fixed, now)
    return Standing(take, 0, 0, False, None, _seen(scene, view.name, start)[0].tolist())


def append_actions(
    workspace: Workspace,
    store: Store,
    take: int,
    first_step: int,
    actions: Array,
    now: float,
    states: Array | None = None,
) -> Standing:
    """The next actions of a take, all of them or none: (steps, m), or (steps, characters, m).

    Where many characters share the world and one action is given for a step, it is the lead's and
    the others rest. Actions beyond the scene's range are brought within it, as any pilot's are.
    `states` (steps, n), what the program saw before each, are compared where they are given. The
    same actions of the same steps may come again; what has been written stays as it is.

    Raises InvalidInputError for actions that cannot be, or states that were not; ConflictError for
    a gap, for other actions of steps that are written, and for a take that is closed.
    """
    going, scene = _going(workspace, store, take)
    rows = _checked(scene, going.moment(scene), actions)
    if first_step > going.pairs:
        raise ConflictError(
            f"Take {take} has {going.pairs} steps, and these begin with step {first_step}; send "
            f"what follows step {going.pairs - 1} first."
        )
    if first_step < going.pairs:
        return _repeated(store, going, scene, first_step, rows, now)
    if going.closed or going.trashed:
        raise ConflictError(
            f"Take {take} is {'closed' if going.closed else 'in the trash'}; begin another."
        )
    if going.pairs + len(rows) > LONGEST:
        raise ConflictError(f"A take has at most {LONGEST} steps; begin another.")
    moments, moment = _enact(scene, going.moment(scene), rows)
    done = rows[: len(moments)]
    if moments:
        moving = stack([Snapshot({}, one.moving) for one in moments]).moving
        seen = _seen(scene, going.perception, moments_of(moment.fixed, moving))
        _compare(states, seen)
        try:
            store.append(take, first_step, seen, done, moving)
        except (
            ConflictError,
            StorageError,
        ):  # another was faster, or the store is in trouble
            going, _ = _going(workspace, store, take)
            if going.pairs <= first_step:
                raise
            return _repeated(store, going, scene, first_step, rows, now)
    return _standing(store, going, scene, moment, first_step + len(done), len(done), now)


def close_take(workspace: Workspace, store: Store, take: int, now: float) -> Standing:
    """End a take, with what has become of its world; again for one that is closed."""
    going, scene = _going(workspace, store, take)
    told = _standing(store, going, scene, going.moment(scene), going.pairs, 0, now)
    if told.closed:
        return told
    store.finish_take(take, None, now)
    return Standing(take, told.pairs, 0, True, None, told.state)


def _going(workspace: Workspace, store: Store, take: int) -> tuple[Unfinished, Scene]:
    going = resume_take(store, take)
    if not going.pilot.startswith(PROGRAM):
        raise ConflictError(
            f"Take {take} was not begun by a program but by {going.pilot!r}; begin one for these "
            "actions."
        )
    record = store.session(going.session)
    scene = make_scene(workspace, record.scene, going.options)
    if scene.version != going.scene_version:
        raise ConflictError(
            f"Take {take} is of version {going.scene_version} of the scene, which is now version "
            f"{scene.version}. Make a new session."
        )
    return going, scene


def _checked(scene: Scene, moment: Snapshot, actions: Array) -> Array:
    """Actions as the scene steps by them, (steps, m) or (steps, characters, m)."""
    size = scene.action.size
    everybody = (len(actions), *scene.characters, size)
    if not 0 < len(actions) <= MOST_STEPS:
        raise InvalidInputError(
            f"{len(actions)} actions were given; send 1 to {MOST_STEPS} at once."
        )
    if scene.characters and actions.shape == everybody:
        flat = finite_rows(actions.reshape(-1, size), size, "actions")
        return scene.action.clip(flat.reshape(everybody))
    names = ", ".join(scene.action.names)
    alone = scene.action.clip(finite_rows(actions, size, "actions", names))
    return np.concatenate([for_all(scene, moment, row[None]) for row in alone])


def _enact(scene: Scene, moment: Snapshot, rows: Array) -> tuple[list[Snapshot], Snapshot]:
    """The moments that `rows` answer, as far as the world goes, and the one after them."""
    moments: list[Snapshot] = []
    for row in rows:
        if scene.outcome(moment)[0] != 0:
            break
        moments.append(moment)
        moment = scene.step(moment, row[None])
    return moments, moment


def _seen(scene: Scene, perception: str, moments: Snapshot) -> Array:
    return of_lead(moments, scene.perception(perception).perceive(moments).states)


def _compare(states: Array | None, seen: Array) -> None:
    """Raise InvalidInputError where a program saw other states than there were."""
    if states is None:
        return
    given = finite_rows(states, seen.shape[1], "states")
    if len(given) < len(seen):
        raise InvalidInputError(f"{len(given)} states were given for more actions.")
    differ = ~np.isclose(given[: len(seen)], seen, rtol=LIKE, atol=LIKE).all(axis=1)
    if differ.any():
        row = int(np.argmax(differ))
        raise InvalidInputError(
            f"State {row} of those given is {given[row].tolist()}, and the world's is "
            f"{seen[row].tolist()}: the program saw another world than the one its actions are "
            "for. Nothing was written."
        )


def _repeated(
    store: Store, going: Unfinished, scene: Scene, first_step: int, rows: Array, now: float
) -> Standing:
    """The answer to actions of steps that are written already."""
    before = written_actions(store, going.id, first_step, len(rows))
    moment = going.moment(scene)
    over = scene.outcome(moment)[0] != 0
    same = np.array_equal(before, rows[: len(before)])
    if not same or (len(before) < len(rows) and not over):
        raise ConflictError(
            f"Steps from {first_step} of take {going.id} are written already, with other actions; "
            f"it has {going.pairs} steps."
        )
    return _standing(store, going, scene, moment, going.pairs, len(before), now)


def _standing(
    store: Store,
    going: Unfinished,
    scene: Scene,
    moment: Snapshot,
    pairs: int,
    accepted: int,
    now: float,
) -> Standing:
    """How the take stands at `moment`; where its world has ended, that is written."""
    code = int(scene.outcome(moment)[0])
    outcome = scene.outcomes[code] if code else None
    if outcome is not None and not going.closed:
        store.finish_take(going.id, outcome, now)
    state = _seen(scene, going.perception, moment)[0].tolist()
    closed = going.closed or outcome is not None
    return Standing(going.id, pairs, accepted, closed, outcome, state)
