"""The traits of a scripted demonstrator: what makes one careful, human-like or on keys."""

from __future__ import annotations

import inspect
from collections.abc import Mapping
from dataclasses import dataclass, field, fields

from evastudio.errors import InvalidInputError
from evastudio.world.scene import Scene
from evastudio.world.spaces import Box


@dataclass(frozen=True)
class Traits:
    """Everything a scripted demonstrator is made of. All at their defaults: a perfect one."""

    intention: Mapping[str, float] = field(default_factory=dict)
    """Traits that the scene's `intention` understands, such as how wide a berth to give."""
    delay_steps: int = 0
    """Decision steps between seeing and answering."""
    delay_jitter_steps: int = 0
    """The delay wanders this far up and down, drawn anew every second."""
    anticipation: float = 0.0
    """Share of the delay, 0 to 1, bridged by foreseeing where the own actions lead."""
    smoothing: float = 0.0
    """Share of the last action kept in the next, 0 to 1: the hand does not jump."""
    tremor: float = 0.0
    """Spread of the unsteadiness of the hand, as a share of half the action's range."""
    mistakes_per_minute: float = 0.0
    """How often a burst of steering the wrong way begins."""
    mistake_steps: int = 4
    """How long such a burst lasts."""
    indecision_per_minute: float = 0.0
    """How often the hand rests for a moment, undecided."""
    indecision_steps: int = 4
    """How long it rests."""
    keys: bool = False
    """Works on/off keys with the scene's ramp, tapping so that the mean is what it wants."""
    key_patience: float = 1.5
    """Decision steps of full deflection that may be owed before a key is pressed."""

    def __post_init__(self) -> None:
        for entry in fields(self):
            value = getattr(self, entry.name)
            if entry.name in ("intention", "keys"):
                continue
            if not isinstance(value, (int, float)) or not 0 <= value < 1e6:
                raise InvalidInputError(
                    f"Trait {entry.name!r} is {value!r}; it must be a number from 0 on."
                )
        for name in ("anticipation", "smoothing"):
            if getattr(self, name) > 1:
                raise InvalidInputError(
                    f"Trait {name!r} is {getattr(self, name)}; it is a share, from 0 to 1."
                )

    def suit(self, scene: Scene) -> bool:
        """Whether `scene` has intentions that understand each of these, and keys to ramp."""
        if type(scene).intention is Scene.intention or (
            self.keys and not (scene.controls and isinstance(scene.action, Box))
        ):
            return False
        return self.intention.keys() <= inspect.signature(scene.intention).parameters.keys()


STYLES: Mapping[str, Traits] = {
    "careful": Traits(smoothing=0.3),
    "human": Traits(
        delay_steps=3,
        delay_jitter_steps=1,
        anticipation=0.7,
        smoothing=0.4,
        tremor=0.06,
        mistakes_per_minute=4.0,
        indecision_per_minute=6.0,
    ),
    "keys": Traits(delay_steps=3, delay_jitter_steps=1, anticipation=0.9, keys=True),
    "hurried": Traits(intention={"room": 1.0, "wander": 0.04, "rest": 0.0}),
    "shy": Traits(intention={"room": 3.0, "wander": 0.12, "rest": 0.2}),
    "startled": Traits(intention={"drop_s": 1.0}),
    "surprised": Traits(intention={"drop_s": 5.0, "drop_within_s": 20.0, "room": 1.0}),
}
"""The scripted demonstrators on offer. None of them is a person; all are programs."""
