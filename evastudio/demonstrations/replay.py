"""Replaying a take: its seed, scene version and actions give its snapshots again."""

from __future__ import annotations

from evastudio.demonstrations.records import RECORDED, TakeData, TakeRecord
from evastudio.errors import ConflictError
from evastudio.world.cast import LEAD
from evastudio.world.scene import Scene
from evastudio.world.snapshot import Snapshot, moments_of, stack


def replay_take(scene: Scene, take: TakeRecord, data: TakeData) -> Snapshot:
    """The moments of `take` stepped anew, along the worlds axis as in `data.snapshots`.

    From its seed, or where its world was recorded elsewhere, from the first of its moments.

    Raises ConflictError where `scene` is not of the take's version and options.
    """
    if (scene.version, dict(scene.values)) != (take.scene_version, dict(take.options)):
        raise ConflictError(
            f"Take {take.id} was made in version {take.scene_version} of its scene with options "
            f"{dict(take.options)}, and this is version {scene.version} with "
            f"{dict(scene.values)}; it replays only in its own."
        )
    recorded = take.seed == RECORDED
    moment = data.snapshots.take(slice(0, 1)) if recorded else scene.worlds([take.seed])
    if LEAD in moment.moving:  # whom the animator chose is no part of the world's seed
        moment = moment.after(lead=data.snapshots[LEAD][:1])
    moments = [moment]
    for action in data.actions[:-1]:
        moment = scene.step(moment, action[None, :])
        moments.append(moment)
    moving = stack([Snapshot({}, moment.moving) for moment in moments]).moving
    return moments_of(moment.fixed, moving)
