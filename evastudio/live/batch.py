"""A batch of headless worlds: a program steps them, without a clock and without a screen."""

from __future__ import annotations

import contextlib
import logging
import math
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from evastudio.demonstrations.records import RECORDED
from evastudio.errors import ConflictError, InvalidInputError, StudioError
from evastudio.live.demonstrating import Demonstration
from evastudio.live.saved import Saved, checked_like
from evastudio.live.stepping import Seen, Stepping
from evastudio.world.cast import LEAD, for_all, of_lead, sound
from evastudio.world.rollout import Memory, Pilot
from evastudio.world.scene import Scene
from evastudio.world.snapshot import AnyArray, Snapshot
from evastudio.world.spaces import Array

logger = logging.getLogger(__name__)

MOST_WORLDS = 1024
MOST_STEPS = 10_000
"""In one call."""
MOST_DECISIONS = 200_000
"""In one call: steps times worlds times characters."""
MOST_BYTES = 128 * 2**20
"""That the worlds of a batch may take in memory."""
LARGEST_SEED = 2**53 - 1


@dataclass(frozen=True)
class Acting:
    """A pilot of the studio at work in a batch."""

    name: str
    pilot: Pilot
    memory: Memory
    """Of the worlds that go on."""


class Batch:
    """Worlds of one scene that a program, or a pilot for it, acts in. Safe to use from several
    threads: one call at a time."""

    def __init__(
        self,
        name: str,
        scene: Scene,
        seeds: Sequence[int],
        *,
        pilots: Callable[[str], Pilot],
        perception: str | None = None,
        demonstration: Demonstration | None = None,
    ) -> None:
        """New worlds of these `seeds`, seen through `perception`; `pilots` finds one by name.

        What the program does becomes takes where there is a `demonstration`, of one world.
        Raises InvalidInputError for seeds that are none, too many, or of worlds too large.
        """
        self.name = name
        self.scene = scene
        self.view = scene.perception(perception)
        self.demonstration = demonstration
        self.used_at = time.monotonic()
        """When the latest call ended, on the monotonic clock."""
        self._pilots = pilots
        self._lock = threading.Lock()
        self._closed = False
        self._acting: Acting | None = None
        self._elsewhere = False
        self._worlds = self._new(seeds)

    @property
    def seeds(self) -> tuple[int, ...]:
        """Of its worlds, in order."""
        return self._worlds.seeds

    @property
    def size(self) -> int:
        """Bytes that its worlds take in memory."""
        return bytes_of(self._worlds.going)

    def reset(self, seeds: Sequence[int]) -> Seen:
        """New worlds in place of those there are; a running take is kept as it is."""
        with self._at_work():
            worlds = self._new(seeds)
            self._break_off()
            self._worlds, self._acting, self._elsewhere = worlds, None, False
            return worlds.see()

    def observe(self) -> Seen:
        """How the worlds are now."""
        with self._at_work():
            return self._worlds.see()

    def step(self, actions: ArrayLike, *, own: bool = False) -> Seen:
        """One decision in every world that goes on, or several one after another.

        `actions` has shape (worlds, m), or (steps, worlds, m); where many characters act
        (worlds, characters, m), or (steps, worlds, characters, m), or (worlds, m) for the leads
        alone while the others rest. They are in the world's frame, or with `own` in that of the
        perception; what lies outside the range is moved to its edge. Rows of worlds that have
        ended count for nothing. Raises InvalidInputError, saying what shape was expected.
        """
        with self._at_work():
            self._acting = None
            for row in self._steps(actions, own):
                if not len(self._worlds.alive):
                    break
                chosen = self._in_world(row[self._worlds.alive], own)
                if self.demonstration is not None:
                    self._record(self.demonstration, chosen)
                self._advance(chosen)
            return self._worlds.see()

    def play(self, pilot: str, steps: int = 1) -> Seen:
        """Let a policy, or another pilot of the studio, take `steps` decisions; none is recorded.

        It remembers what it saw until another pilot or the program acts. Raises NotFoundError for
        one that there is not, ConflictError for one that does not fit the scene.
        """
        with self._at_work():
            self._affordable(steps)
            if self._acting is None or self._acting.name != pilot:
                self._acting = self._begun(pilot, self._worlds)
            self._break_off()
            for _ in range(steps):
                if not len(self._worlds.alive):
                    break
                acting = self._acting
                chosen, memory = acting.pilot.act(self.scene, self._worlds.going, acting.memory)
                self._acting = replace(acting, memory=memory)
                self._advance(sound(self.scene, chosen))
            return self._worlds.see()

    def save(self) -> Saved:
        """Everything about the worlds now, so that they can go on from here."""
        with self._at_work():
            acting = self._acting
            return Saved(
                self.scene.identity(),
                self._worlds.seeds,
                self._worlds.see().steps,
                self._worlds.snapshot(),
                None if acting is None else acting.name,
                None if acting is None else acting.memory,
            )

    def restore(self, saved: Saved) -> Seen:
        """Go on from what was saved, here or in another batch, of this scene with these options.

        A running take is kept as it is; what is demonstrated from here on is a take that begins
        here. Raises InvalidInputError for what is no moment of such worlds.
        """
        with self._at_work():
            if saved.scene != self.scene.identity():
                raise InvalidInputError(
                    f"This was saved of {saved.scene}, and these are worlds of "
                    f"{self.scene.identity()}. Open worlds with the same options."
                )
            begun = self._made(saved.seeds)
            moving = checked_like(saved.snapshot.moving, begun.moving, "snapshot")
            if saved.snapshot.fixed:
                fixed = checked_like(saved.snapshot.fixed, begun.fixed, "snapshot")
                if any((fixed[name] != array).any() for name, array in begun.fixed.items()):
                    raise InvalidInputError(
                        "The worlds of the snapshot are not those of its seeds."
                    )
            moving = {name: np.array(array) for name, array in moving.items()}
            snapshot = Snapshot(begun.fixed, moving)
            try:
                worlds = Stepping(self.scene, self.view, saved.seeds, snapshot, saved.steps)
                self._try(worlds.going)
                acting = None if saved.pilot is None else self._going_on(saved, worlds)
            except StudioError:
                raise
            except Exception as error:  # whatever a scene does with numbers it never gave
                raise InvalidInputError(
                    "The numbers of the snapshot are no moment of this scene "
                    f"({type(error).__name__}). Restore one as it was downloaded."
                ) from None
            self._break_off()
            self._worlds, self._acting, self._elsewhere = worlds, acting, True
            return worlds.see()

    def close(self) -> None:
        """Let go of the worlds; a running take is kept. Raises StorageError where it is not."""
        with self._lock:
            self._closed = True
            if self.demonstration is not None:
                self.demonstration.close()

    # -- inside --------------------------------------------------------------------------------

    @contextlib.contextmanager
    def _at_work(self) -> Iterator[None]:
        """One call at a time; a scene or pilot that fails ends the take, not the batch."""
        with self._lock:
            if self._closed:
                raise ConflictError("These worlds are closed; open others.")
            try:
                yield
            except StudioError:
                raise
            except Exception as error:  # scenes and pilots are other people's code
                logger.exception("Worlds %s could not be stepped", self.name)
                self._break_off()
                raise ConflictError(
                    "The scene or the character failed; the server's log tells why. The worlds are "
                    "as they were before; reset or restore them."
                ) from error
            finally:
                self.used_at = time.monotonic()

    def _made(self, seeds: Sequence[int]) -> Snapshot:
        """New worlds of `seeds`, refused before they are made where they would be too many."""
        alone = self.demonstration is not None
        most = 1 if alone else MOST_WORLDS
        if not 1 <= len(seeds) <= most:
            why = "; a demonstration is of one world" if alone else ""
            raise InvalidInputError(
                f"{len(seeds)} seeds were given; expected 1 to {most}, one for each world{why}."
            )
        if not all(0 <= seed <= LARGEST_SEED for seed in seeds):
            raise InvalidInputError(f"Seeds are whole numbers from 0 to {LARGEST_SEED}.")
        first = self.scene.worlds(seeds[:1])
        size = bytes_of(first)
        if size * len(seeds) > MOST_BYTES:
            raise InvalidInputError(
                f"{len(seeds)} worlds of {size / 2**20:.1f} MB each are too large; ask for at most "
                f"{MOST_BYTES // size}."
            )
        return first if len(seeds) == 1 else self.scene.worlds(seeds)

    def _new(self, seeds: Sequence[int]) -> Stepping:
        steps = np.zeros(len(seeds), dtype=np.int64)
        return Stepping(self.scene, self.view, seeds, self._made(seeds), steps)

    def _affordable(self, steps: int) -> None:
        decisions = steps * len(self.seeds) * math.prod(self.scene.characters)
        if not 1 <= steps <= MOST_STEPS or decisions > MOST_DECISIONS:
            raise InvalidInputError(
                f"{steps} steps come to {decisions} decisions; one call takes 1 to {MOST_STEPS} "
                f"steps and at most {MOST_DECISIONS} decisions of all characters. Make several."
            )

    def _steps(self, actions: ArrayLike, own: bool) -> Array:
        """`actions` checked, with a leading axis for steps."""
        size = (self.scene.chosen(self.view) if own else self.scene.action).size
        try:
            table = np.asarray(actions, dtype=np.float64)
        except (TypeError, ValueError) as error:
            raise InvalidInputError(f"The actions are not a table of numbers ({error}).") from None
        count, many = len(self.seeds), self.scene.characters
        shapes = dict.fromkeys([(count, size), (count, *many, size)])
        if table.shape in shapes:
            table = table[None]
        elif table.shape[1:] != (count, *many, size):
            known = " or ".join(str(shape) for shape in shapes)
            raise InvalidInputError(
                f"The actions have shape {table.shape}; expected {known}, or (steps, "
                f"{', '.join(str(length) for length in (count, *many, size))})."
            )
        self._affordable(len(table))
        space = self.scene.chosen(self.view) if own else self.scene.action
        return space.check(table.reshape(-1, size), "actions").reshape(table.shape)

    def _in_world(self, chosen: Array, own: bool) -> Array:
        """What all who go on do, in the world's frame, for the rows of those that go on."""
        worlds = self._worlds
        leads = bool(self.scene.characters) and chosen.ndim == 2
        if own:
            frame = worlds.percept.frame
            chosen = self.view.to_world(of_lead(worlds.going, frame) if leads else frame, chosen)
        if leads:
            chosen = for_all(self.scene, worlds.going, chosen)
        return self.scene.action.clip(chosen)

    def _advance(self, chosen: Array) -> None:
        on = self._worlds.advance(chosen)
        if on.all():
            return
        if self._acting is not None:
            memory = {name: array[on] for name, array in self._acting.memory.items()}
            self._acting = replace(self._acting, memory=memory)
        if self.demonstration is not None:
            (code,) = self._worlds.see().outcomes
            self.demonstration.end(self.scene.outcomes[int(code)])

    def _begun(self, name: str, worlds: Stepping) -> Acting:
        pilot = self._pilots(name)
        seeds = [worlds.seeds[row] for row in worlds.alive]
        return Acting(name, pilot, pilot.begin(self.scene, seeds) if seeds else {})

    def _try(self, moment: Snapshot) -> None:
        """Step once at rest from a moment that came from outside, to no effect."""
        lead = moment.moving.get(LEAD)
        if lead is not None and not ((lead >= 0) & (lead < self.scene.characters[0])).all():
            raise InvalidInputError("The snapshot is led by a character that there is not.")
        if moment.worlds:
            rest = np.zeros((moment.worlds, *self.scene.characters, self.scene.action.size))
            self.scene.step(moment, self.scene.action.clip(rest))

    def _going_on(self, saved: Saved, worlds: Stepping) -> Acting:
        """The pilot that was acting, with what it remembered."""
        fresh = self._begun(str(saved.pilot), worlds)
        memory: dict[str, AnyArray] = dict(saved.memory or {})
        if not len(worlds.alive):
            return fresh
        _, like = fresh.pilot.act(self.scene, worlds.going, fresh.memory)
        known = fresh.memory if memory.keys() == fresh.memory.keys() else like
        memory = checked_like(memory, known, "pilot's memory")
        fresh.pilot.act(self.scene, worlds.going, memory)
        return replace(fresh, memory=memory)

    def _record(self, demonstration: Demonstration, chosen: Array) -> None:
        """One pair; the first one begins a take, and where that is not its world's beginning it
        begins with this moment instead of the seed."""
        worlds = self._worlds
        if not demonstration.running:
            afresh = not self._elsewhere and not worlds.see().steps.any()
            demonstration.begin(self.scene, worlds.going, worlds.seeds[0] if afresh else RECORDED)
        seen = worlds.percept.states
        if self.view is not self.scene.perception():
            seen = self.scene.perception().perceive(worlds.going).states
        demonstration.add(of_lead(worlds.going, seen), chosen, worlds.going)

    def _break_off(self) -> None:
        if self.demonstration is not None:
            self.demonstration.end(None)


def bytes_of(snapshot: Snapshot) -> int:
    """What its arrays take in memory."""
    fixed, _ = snapshot.shared()
    return sum(array.nbytes for part in (fixed, snapshot.moving) for array in part.values())
