"""A pair beside what was done in moments like it: where each of those actions leads."""

from __future__ import annotations

import numpy as np

from evastudio.live.conflicts import Conflicts
from evastudio.live.reel import Reel
from evastudio.live.sketch import FAMILIAR, STRANGE, ways
from evastudio.world.bodies import Line
from evastudio.world.cast import of_lead


def sketch_of(found: Conflicts, row: int, reel: Reel, step: int) -> tuple[Line, ...]:
    """Where the action of pair `row` leads from that step of its take, and those of its neighbours.

    They are as they would be there, in its frame; its own is the last. Raises NotFoundError where
    the scene has lost the perception that they were compared under.
    """
    scene, moment = reel.scene, reel.moment(step)
    view = scene.perception(found.about.perception)
    own = found.actions[np.append(found.neighbors[row], row)]
    frame = of_lead(moment, view.perceive(moment).frame)[:1]
    actions = view.to_world(np.repeat(frame, len(own), axis=0), own)
    colors = np.tile(np.array(FAMILIAR, dtype=np.uint8), (len(own), 1))
    colors[-1] = STRANGE
    return ways(scene, moment, actions, colors)
