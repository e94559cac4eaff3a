"""Footage: what happened in a run, as data that another process can draw."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from evastudio.demonstrations.records import Origin
from evastudio.demonstrations.store import Store
from evastudio.errors import ConflictError, InvalidInputError
from evastudio.live.headless import make_scene
from evastudio.live.piloting import load_pilot, scene_of
from evastudio.live.reel import Reel
from evastudio.workspace import Workspace
from evastudio.world.bodies import Camera
from evastudio.world.rollout import roll_out
from evastudio.world.snapshot import AnyArray, Snapshot
from evastudio.world.spaces import Array

LONGEST_S = 600.0
"""Of what is made into a film."""
MOST_BYTES = 64 * 2**20
"""Of what moves in it; jobs that wait, and some that have ended, hold theirs in memory."""


@dataclass(frozen=True)
class Footage:
    """The moments of a run, each a decision step after the one before."""

    scene: str
    options: Mapping[str, float]
    fixed: Mapping[str, AnyArray]
    """Of the one world, leading axis 1."""
    moving: Mapping[str, AnyArray]
    """Leading axis moments."""
    camera: str | None
    """From where it is seen; the scene's first camera where it is None."""
    name: str
    """Of a file: small letters, digits and dashes."""
    title: str
    """What a person reads."""

    @property
    def moments(self) -> int:
        return len(next(iter(self.moving.values())))

    def reel(self, workspace: Workspace) -> Reel:
        """The run in its scene. Raises NotFoundError where that is gone."""
        reel = Reel(make_scene(workspace, self.scene, self.options), Origin(0))
        for at in range(self.moments):
            now = {name: array[at : at + 1] for name, array in self.moving.items()}
            reel.add(Snapshot(self.fixed, now))
        return reel


def frame_count(reel: Reel, fps: int) -> int:
    """Frames of a run, `fps` in a second; the first shows its first moment."""
    return int((reel.last - reel.first) * reel.scene.dt_s * fps) + 1


def frames(reel: Reel, camera: str | None, fps: int) -> Iterator[tuple[Snapshot, Camera]]:
    """The run as it looked at each frame, and from where it is seen."""
    for number in range(frame_count(reel, fps)):
        moment = reel.shown(reel.first + number / fps / reel.scene.dt_s)
        cameras = reel.scene.cameras(moment)
        yield moment, cameras[camera] if camera else next(iter(cameras.values()))


def footage_of(
    reel: Reel, moments: Sequence[Snapshot], camera: str | None, name: str, title: str
) -> Footage:
    """Of `moments` of `reel`. Raises ConflictError where nothing moves, InvalidInputError where it
    is too long, or has no such camera."""
    scene = reel.scene
    if len(moments) < 2:
        raise ConflictError("Nothing has moved yet. Demonstrate or play first, then share it.")
    if (len(moments) - 1) * scene.dt_s > LONGEST_S:
        raise InvalidInputError(
            f"It lasts {(len(moments) - 1) * scene.dt_s:.0f} s; films last {LONGEST_S:g} s at most."
        )
    if (size := len(moments) * sum(one.nbytes for one in moments[0].moving.values())) > MOST_BYTES:
        raise InvalidInputError(
            f"What moves in it takes {size / 2**20:,.0f} MB, and a film's may take "
            f"{MOST_BYTES // 2**20}. Choose a shorter run or fewer characters."
        )
    known = scene.cameras(moments[0])
    if camera is not None and camera not in known:
        raise InvalidInputError(
            f"{camera!r} is no camera of scene {scene.name!r}; it has {', '.join(known)}."
        )
    held = [one.moving for one in moments]
    return Footage(
        scene.name,
        dict(scene.values),
        {key: np.array(array) for key, array in moments[0].fixed.items()},
        {key: np.concatenate([one[key] for one in held]) for key in held[0]},
        camera,
        name,
        title,
    )


def take_footage(workspace: Workspace, store: Store, take: int, camera: str | None) -> Footage:
    """Of a recorded take. Raises NotFoundError, and ConflictError where its scene has changed."""
    record = store.take(take)
    session = store.session(record.session)
    scene = make_scene(workspace, session.scene, record.options)
    if record.scene_version != scene.version:
        raise ConflictError(
            f"Take {record.number} of {session.name!r} is of version {record.scene_version} of "
            f"scene {scene.name!r}, which is version {scene.version} now; it cannot be drawn."
        )
    if not record.pairs:
        raise ConflictError(f"Nothing was recorded in take {record.number} of {session.name!r}.")
    reel = Reel.of_take(scene, record, store.load_take(take))
    title = f"{scene.title}: take {record.number} of {session.name}"
    return footage_of(reel, reel.moments(), camera, f"{file_name(scene.name)}-take-{take}", title)


def policy_footage(
    workspace: Workspace,
    policy: str,
    seed: int,
    options: Mapping[str, float] | None,
    camera: str | None,
    scene: str | None = None,
) -> Footage:
    """What a policy (or another pilot) does in the world of `seed`. Raises NotFoundError."""
    place = make_scene(workspace, scene or scene_of(workspace, [policy]), options)
    reel = Reel(place, Origin(0, policy=policy, seed=seed))
    latest: list[tuple[Snapshot, Array]] = []

    def watch(_: NDArray[np.int64], moment: Snapshot, actions: Array) -> None:
        reel.add(moment)
        latest[:] = [(moment, actions)]

    most = int(LONGEST_S / place.dt_s)
    roll_out(place, load_pilot(workspace, policy, place), [seed], max_steps=most, watcher=watch)
    reel.add(place.step(*latest[0]))
    name = f"{file_name(place.name)}-{file_name(policy)}-{seed}"
    return footage_of(reel, reel.moments(), camera, name, f"{place.title}: {policy}, world {seed}")


def file_name(text: str) -> str:
    """`text` in what a file's name may hold: small letters, digits and dashes."""
    return re.sub(r"[^a-z0-9]+", "-", text.lower()).strip("-")[:80] or "run"
