"""Going to a moment of a world as a pilot comes there: to look at what follows, or to steer it."""

from __future__ import annotations

import math

from evastudio.errors import ConflictError, InvalidInputError
from evastudio.live.act import FEW
from evastudio.live.run import Run
from evastudio.pilots.why import Reasoner
from evastudio.world.cast import sound
from evastudio.world.rollout import Memory, Pilot
from evastudio.world.scene import Scene

LONGEST = 10_000
"""Decision steps that are gone through while a person waits."""


def approach(
    scene: Scene, pilot: Pilot, seed: int, steps: int, reasoner: Reasoner
) -> tuple[Run, Memory]:
    """The run of `pilot` in the world of `seed` up to step `steps`, and what it then remembers.

    Raises ConflictError where that world ends before, InvalidInputError for more than LONGEST.
    """
    if steps > LONGEST:
        raise InvalidInputError(
            f"{steps * scene.dt_s:g} s into a world is farther than anybody waits for; at most "
            f"{LONGEST * scene.dt_s:g} s."
        )
    run = Run.new(scene, seed, policy=pilot.name)
    memory = pilot.begin(scene, [seed])
    few = math.prod(scene.characters) <= FEW
    for _ in range(steps):
        if few:
            run.reel.note(reasoner.why(scene, run.after, memory))
        actions, memory = pilot.act(scene, run.after, memory)
        run.step(sound(scene, actions))
        if run.outcome is not None:
            raise ConflictError(
                f"{pilot.name!r} goes another way in that world by now: it ends after "
                f"{run.steps * scene.dt_s:.1f} s. Look for failures again."
            )
    run.stand()
    return run, memory
