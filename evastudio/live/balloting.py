"""Ballots with the studio's own pilots: opened, shown without names, and voted on."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Literal

from evastudio.demonstrations.store import Store
from evastudio.errors import BusyError, ConflictError, InvalidInputError, StudioError
from evastudio.evaluation import preferences
from evastudio.evaluation.preferences import Ballot
from evastudio.live.headless import make_scene
from evastudio.live.lineups import Lineups, Opened, World
from evastudio.live.piloting import fingerprint, fitted_anew, load_pilot
from evastudio.workspace import Workspace

CHANGED = (
    "One of the two has changed since people were asked about them, or is gone. Ask whoever runs "
    "this studio to ask anew."
)
"""Says no name: nobody is to know them."""


def open_ballot(
    workspace: Workspace,
    store: Store,
    scene: str,
    pilots: Sequence[str],
    *,
    options: Mapping[str, float],
    seed: int,
    now: float,
) -> Ballot:
    """Ask people about two pilots of a scene. Raises NotFoundError, InvalidInputError."""
    place = make_scene(workspace, scene, options)
    if len(set(pilots)) != 2:
        raise InvalidInputError("Name two different pilots for people to choose between.")
    for name in pilots:
        load_pilot(workspace, name, place)
    marks = {name: fingerprint(workspace, name) for name in pilots}
    return preferences.open_ballot(store, place.identity(), marks, seed, now)


def show(
    workspace: Workspace, lineups: Lineups, store: Store, ballot: Ballot, voter: str
) -> Opened:
    """The two as `voter` sees them next. Raises ConflictError where one is not what it was."""
    number = preferences.votes_of(store, ballot.id, voter)
    world = World(ballot.scene, ballot.options, ballot.seed, number)
    try:
        place = make_scene(workspace, ballot.scene, ballot.options)
        same = place.version == ballot.scene_version and not fitted_anew(workspace, ballot.pilots)
        if same:
            order = ballot.order(voter, number)
            return lineups.open_blind(voter, world, list(ballot.pilots), ballot.id, order)
    except BusyError:
        raise
    except StudioError:
        raise ConflictError(CHANGED) from None
    raise ConflictError(CHANGED)


def vote(
    store: Store,
    ballot: Ballot,
    opened: Opened,
    livelier: Literal["left", "right", "neither"],
    now: float,
) -> tuple[str, str]:
    """Keep what was found of the two in a lineup of `ballot`; who stood left and right.

    Raises ConflictError for another's lineup, and where it was voted on already.
    """
    if opened.ballot != ballot.id:
        raise ConflictError("That lineup is not of this ballot. Ask it for two to look at.")
    chosen = {"left": opened.order[0], "right": opened.order[1]}.get(livelier)
    preferences.vote(store, ballot, opened.owner, opened.world.number, chosen, now)
    names = list(ballot.pilots)
    return names[opened.order[0]], names[opened.order[1]]
