"""The websocket for many steps a second: numbers in, numbers out, nothing to parse.

A binary message is a step, or several: the actions, one after another, as little-endian float64 in
the order of `Batch.step`'s shapes. Its answer is a binary message of one row for each world,
little-endian float64 too: outcome (its code), progress, steps, and the state, or those of everybody
in turn. A text message is a command as JSON, `{"do": "observe"}`, `{"do": "reset", "seeds": [...]}`
or `{"do": "play", "pilot": ..., "steps": ...}`, and is answered likewise. What cannot be done is
answered by a text message, a problem as over HTTP, and the worlds stay as they were. Every message
has one answer, in order, so that many can be on their way at once.
"""

from __future__ import annotations

import asyncio
import contextlib
import json
import logging
import math
from typing import Annotated, Literal

import numpy as np
from fastapi import APIRouter, Query, WebSocket, WebSocketDisconnect
from pydantic import Field, TypeAdapter, ValidationError

from evastudio.api.context import Studio
from evastudio.api.models.common import Model
from evastudio.api.models.worlds import PlayIn, ResetIn
from evastudio.api.problems import problem, problem_response
from evastudio.errors import InvalidInputError, NotFoundError, StudioError
from evastudio.live.batch import Batch
from evastudio.live.stepping import Seen
from evastudio.world.spaces import Array

router = APIRouter(prefix="/worlds", tags=["worlds"])
logger = logging.getLogger(__name__)

MOST_BYTES = 2**20
"""Of one message; larger ones go over HTTP."""
WAITING = 64
"""Messages that may wait; then the connection is not read from."""
TOGETHER = 16
"""Messages answered in one go, so that a hand-over between threads is paid once."""


class Observe(Model):
    do: Literal["observe"]


class Reset(ResetIn):
    do: Literal["reset"]


class Play(PlayIn):
    do: Literal["play"]


COMMAND: TypeAdapter[Observe | Reset | Play] = TypeAdapter(
    Annotated[Observe | Reset | Play, Field(discriminator="do")]
)


@router.websocket("/{worlds}/socket")
async def stream_worlds(
    websocket: WebSocket,
    worlds: str,
    studio: Studio,
    frame: Annotated[Literal["world", "own"], Query()] = "world",
) -> None:
    """Step worlds many times a second; see the module."""
    try:
        batch = studio.worlds.get(worlds)
    except NotFoundError as error:
        await websocket.send_denial_response(problem_response(404, "Not found", str(error)))
        return
    await websocket.accept()
    await Stream(websocket, batch, own=frame == "own").run()


class Stream:
    """One program at a batch."""

    def __init__(self, websocket: WebSocket, batch: Batch, *, own: bool) -> None:
        self._websocket = websocket
        self._batch = batch
        self._own = own
        self._waiting: asyncio.Queue[str | bytes] = asyncio.Queue(WAITING)

    async def run(self) -> None:
        """Until the program goes."""
        answering = asyncio.create_task(self._answer())
        receiving = asyncio.create_task(self._receive())
        try:
            await asyncio.wait((answering, receiving), return_when=asyncio.FIRST_COMPLETED)
        finally:
            for task in (answering, receiving):
                task.cancel()
            await asyncio.gather(answering, receiving, return_exceptions=True)

    async def _receive(self) -> None:
        with contextlib.suppress(WebSocketDisconnect):
            while True:
                message = await self._websocket.receive()
                self._websocket._raise_on_disconnect(message)
                data = message.get("bytes")
                await self._waiting.put(message["text"] if data is None else data)

    async def _answer(self) -> None:
        with contextlib.suppress(WebSocketDisconnect):
            while True:
                asked = [await self._waiting.get()]
                while len(asked) < TOGETHER and not self._waiting.empty():
                    asked.append(self._waiting.get_nowait())
                for told in await asyncio.to_thread(self._all_done, asked):
                    if isinstance(told, bytes):
                        await self._websocket.send_bytes(told)
                    else:
                        await self._websocket.send_text(told)

    def _all_done(self, asked: list[str | bytes]) -> list[str | bytes]:
        return [self._done(message) for message in asked]

    def _done(self, message: str | bytes) -> str | bytes:
        """The answer to one message; on a thread."""
        try:
            if len(message) > MOST_BYTES:
                raise InvalidInputError(
                    f"The message has {len(message)} bytes; at most {MOST_BYTES} are taken through "
                    "the websocket. Send it over HTTP, or fewer steps at once."
                )
            return rows_of(self._seen(message))
        except StudioError as error:
            return json.dumps(problem(error))
        except ValidationError as error:
            first = error.errors(include_url=False)[0]
            where = ".".join(str(part) for part in first["loc"])
            return json.dumps(problem(InvalidInputError(f"{where or 'command'}: {first['msg']}")))
        except Exception:
            logger.exception("A message to worlds %s failed", self._batch.name)
            told = "This did not work, for a reason that the server's log tells."
            return json.dumps(problem(StudioError(told)))

    def _seen(self, message: str | bytes) -> Seen:
        if isinstance(message, bytes):
            return self._batch.step(self._laid_out(message), own=self._own)
        match COMMAND.validate_json(message):
            case Reset(seeds=seeds):
                return self._batch.reset(seeds)
            case Play(pilot=pilot, steps=steps):
                return self._batch.play(pilot, steps)
            case _:
                return self._batch.observe()

    def _laid_out(self, message: bytes) -> Array:
        """The actions of a message in one of the shapes of `Batch.step`."""
        scene, worlds = self._batch.scene, len(self._batch.seeds)
        size = (scene.chosen(self._batch.view) if self._own else scene.action).size
        leads = (worlds, size)
        step = (worlds, *scene.characters, size)
        count, odd = divmod(len(message), 8 * math.prod(step))
        if len(message) == 8 * math.prod(leads):
            shape: tuple[int, ...] = leads
        elif count and not odd:
            shape = (count, *step)
        else:
            raise InvalidInputError(
                f"The message has {len(message)} bytes; expected a whole number of steps of "
                f"{' x '.join(str(length) for length in step)} float64, "
                f"{8 * math.prod(step)} bytes each."
            )
        return np.frombuffer(message, dtype="<f8").reshape(shape)


def rows_of(seen: Seen) -> bytes:
    """One row for each world: outcome, progress, steps, states."""
    count = len(seen.steps)
    rows = np.empty((count, 3 + seen.states[0].size), dtype="<f8")
    rows[:, 0], rows[:, 1], rows[:, 2] = seen.outcomes, seen.progress, seen.steps
    rows[:, 3:] = seen.states.reshape(count, -1)
    return rows.tobytes()
