"""Routes: live stages, and the websocket through which a person drives one."""

from __future__ import annotations

import asyncio
import contextlib
import logging
import time
from typing import Any

from fastapi import APIRouter, WebSocket, WebSocketDisconnect, status
from pydantic import BaseModel, ConfigDict, Field, ValidationError
from pydantic_core import to_json

from evastudio.api.attendance import Attendance
from evastudio.api.context import Context, Studio
from evastudio.api.models.common import Page
from evastudio.api.models.stages import CommandIn, KeysIn, StageIn, StageOut
from evastudio.api.outbox import Outbox
from evastudio.api.paging import NamedPage
from evastudio.api.people import Visitor
from evastudio.api.rights import REFUSAL
from evastudio.errors import InvalidInputError, NotFoundError, StudioError
from evastudio.live.inputs import Feel
from evastudio.live.jobs import Job
from evastudio.live.live_stage import LiveStage
from evastudio.live.pace import Pace
from evastudio.live.pushing import Push
from evastudio.live.series import Arrangement
from evastudio.live.tokens import Role

router = APIRouter(prefix="/stages", tags=["stages"])
logger = logging.getLogger(__name__)

MAX_AGE_S = 0.25
"""An edge of a key is believed to be at most this old."""
LONGEST = 16_384
"""Letters of a message."""
PER_S, AT_ONCE = 200.0, 600.0
"""Messages from one page, which tells of each change of the keys and little else."""
WAITING = 64
"""Commands that may wait to be done."""


@router.post("", status_code=status.HTTP_201_CREATED)
async def open_stage(body: StageIn, studio: Studio) -> StageOut:
    """A new stage. It closes itself when nobody drives it for a minute."""
    stage = await asyncio.to_thread(
        studio.stages.open, body.scene, body.options, body.session, body.seed
    )

    def close() -> None:
        studio.background(_close_idle(stage.name, studio))

    studio.attendances[stage.name] = Attendance(stage, close)
    return _stage(stage)


@router.get("")
def list_stages(studio: Studio, paging: NamedPage) -> Page[StageOut]:
    """The stages that are open now, the first opened first."""
    return paging.page(studio.stages.all(), lambda stage: stage.name, _stage)


@router.get("/{stage}")
def get_stage(stage: str, studio: Studio) -> dict[str, Any]:
    """How a stage stands."""
    return studio.stages.get(stage).status()


@router.post("/{stage}/commands")
async def command_stage(stage: str, body: CommandIn, studio: Studio) -> dict[str, Any]:
    """Do on a stage what a person does; how it then stands."""
    found = studio.stages.get(stage)
    attendance = studio.attendances.get(stage)
    if attendance is not None:
        attendance.seen()
    await asyncio.to_thread(perform, found, body)
    return await asyncio.to_thread(found.status)


@router.delete("/{stage}", status_code=status.HTTP_204_NO_CONTENT)
async def close_stage(stage: str, studio: Studio) -> None:
    """Close a stage; its running take is kept."""
    await _close(stage, studio)


@router.websocket("/{stage}/socket")
async def drive(websocket: WebSocket, stage: str, studio: Studio, visitor: Visitor) -> None:
    """Keys and commands in, status, jobs and notices out, as JSON messages with a `type`.

    From a viewer nothing is taken in.
    """
    attendance = studio.attendances.get(stage)
    try:
        found = studio.stages.get(stage)
    except StudioError:
        attendance = None
    if attendance is None:
        await websocket.close(4404, "There is no such stage; load the page again.")
        return
    await websocket.accept()
    await Drive(websocket, found, attendance, studio, visitor.role).run()


class _Message(BaseModel):
    model_config = ConfigDict(extra="allow")
    type: str = Field(max_length=20)


class Drive:
    """One page at one stage."""

    def __init__(
        self,
        websocket: WebSocket,
        stage: LiveStage,
        attendance: Attendance,
        studio: Context,
        role: Role,
    ) -> None:
        self._websocket = websocket
        self._stage = stage
        self._attendance = attendance if role is Role.AUTHOR else None
        """Who only watches does not keep a stage open."""
        self._studio = studio
        self._loop = asyncio.get_running_loop()
        self._out = Outbox()
        self._commands: asyncio.Queue[CommandIn] = asyncio.Queue()
        self._lag_s = float("inf")
        self._release: asyncio.TimerHandle | None = None

    async def run(self) -> None:
        if self._attendance is not None:
            self._attendance.came()
        self._stage.on_status.append(self._told_status)
        self._studio.job_listeners.add(self._told_job)
        self._studio.outgoing.add(self._out)
        tasks = [
            asyncio.create_task(work)
            for work in (self._receive(), self._send(), self._perform_all())
        ]
        try:
            self._stage.refresh()
            await asyncio.wait(tasks, return_when=asyncio.FIRST_COMPLETED)
        except StudioError:
            pass  # the stage was closed meanwhile
        finally:
            self._release_after(None)
            for task in tasks:
                task.cancel()
            await asyncio.gather(*tasks, return_exceptions=True)
            self._studio.job_listeners.discard(self._told_job)
            self._studio.outgoing.discard(self._out)
            self._stage.on_status.remove(self._told_status)
            if self._attendance is not None:
                self._let_go()
                self._attendance.left()

    def _told_status(self, told: dict[str, Any]) -> None:
        """On the stage's thread."""
        self._studio.post.tell(self._out, {"type": "status", **told})

    def _told_job(self, job: Job) -> None:
        self._out.put({"type": "job", **job.to_json()})

    async def _send(self) -> None:
        while True:
            told = to_json(await self._out.get())
            await self._websocket.send_text(told.decode())

    async def _receive(self) -> None:
        pace = Pace(PER_S, AT_ONCE)
        try:
            while True:
                text = await self._websocket.receive_text()
                if len(text) > LONGEST:
                    await self._websocket.close(1009, "No message of a page is as long.")
                    return
                if not pace.allows(self._loop.time()):
                    await self._websocket.close(1008, "Too many messages at once.")
                    return
                try:
                    self._take_in(text)
                except ValidationError:
                    self._notice("The page sent something that the server does not understand.")
                except StudioError as error:
                    self._notice(str(error))
        except WebSocketDisconnect:
            return
        except KeyError:
            await self._websocket.close(1003, "Messages are text.")

    def _take_in(self, text: str) -> None:
        if self._attendance is None:
            raise InvalidInputError(REFUSAL)
        message = _Message.model_validate_json(text)
        content = message.model_extra or {}
        if message.type == "keys":
            keys = KeysIn.model_validate(content)
            late = time.time() - keys.time_ms / 1000.0
            self._lag_s = min(self._lag_s, late)
            age_s = min(max(late - self._lag_s, 0.0), MAX_AGE_S)
            self._stage.hold(keys.held, age_s, by=self, pushed=keys.pushed)
            self._release_after(keys.for_ms)
            self._out.put({"type": "ack", "seq": keys.seq})
        elif message.type == "command":
            if self._commands.qsize() >= WAITING:
                raise InvalidInputError("Too many commands at once; wait for the stage to answer.")
            self._commands.put_nowait(CommandIn.model_validate(content))
        else:
            raise InvalidInputError(
                f"A message of type {message.type!r} is not known; 'keys' and 'command' are."
            )

    def _release_after(self, wait_ms: float | None) -> None:
        """Let go of every key then, or never where it is None; what was said before is void."""
        if self._release is not None:
            self._release.cancel()
            self._release = None
        if wait_ms is not None:
            self._release = self._loop.call_later(wait_ms / 1000.0, self._let_go)

    def _let_go(self) -> None:
        with contextlib.suppress(StudioError):  # the stage was closed meanwhile
            self._stage.hold([], by=self)

    async def _perform_all(self) -> None:
        while True:
            command = await self._commands.get()
            try:
                await asyncio.to_thread(perform, self._stage, command)
            except StudioError as error:
                self._notice(str(error))
            except Exception:
                logger.exception("The command %r failed", command.name)
                self._notice("This did not work, for a reason that the server's log tells.")

    def _notice(self, text: str) -> None:
        self._out.put({"type": "notice", "level": "error", "text": text})


async def _close_idle(stage: str, studio: Context) -> None:
    with contextlib.suppress(NotFoundError):  # somebody was faster
        await _close(stage, studio)


async def _close(stage: str, studio: Context) -> None:
    attendance = studio.attendances.pop(stage, None)
    if attendance is not None:
        attendance.end()
    await asyncio.to_thread(studio.stages.close, stage)
    for hook in studio.stage_closed:
        hook(stage)


def perform(stage: LiveStage, command: CommandIn) -> None:
    """One command of a person. Raises StudioError where it is not possible."""
    match command.name:
        case "demonstrate":
            stage.demonstrate(command.options, command.others, pushes=command.pushes)
        case "play":
            if command.policy is None:
                raise InvalidInputError("No policy was named; choose one to play.")
            stage.play(command.policy, command.options, command.seed, command.seconds)
        case "session":
            stage.choose_session(command.session)
        case "signal":
            if command.signal is None:
                raise InvalidInputError("No signal was named; choose one of the scene's.")
            stage.signal(command.signal, command.pointer)
        case "camera":
            stage.look_through(command.camera)
        case "another":
            stage.lead_another()
        case "pause":
            stage.pause()
        case "resume":
            stage.resume()
        case "restart":
            stage.restart(command.same)
        case "fork":
            stage.looking_back.fork(command.others)
        case "take-over":
            stage.correcting.take_over()
        case "hand-back":
            stage.correcting.hand_back()
        case "keep-last":
            stage.looking_back.keep_last(command.seconds, command.take)
        case "review":
            stage.looking_back.review(command.take, command.seconds)
        case "compare":
            if command.take is None:
                raise InvalidInputError("No take was named; say which moment of which take.")
            stage.looking_back.compare(command.take, command.step)
        case "leave":
            stage.looking_back.leave()
        case "seek":
            stage.looking_back.seek(command.seconds)
        case "roll":
            stage.looking_back.roll(command.speed)
        case "forget":
            if command.take is None:
                raise InvalidInputError("No take was named; say which moment of which take.")
            stage.correcting.forget(command.take, command.step)
        case "visit":
            if command.take is None or command.push is None:
                raise InvalidInputError("No take and push were given; say from where to go where.")
            push = Push(tuple(command.push.keys), command.push.steps)
            stage.looking_back.visit(command.take, command.step, push, command.others)
        case "feel":
            stage.suit(Feel(command.sensitivity, command.ramp))
        case "series":
            stage.arrange(Arrangement(command.wanted, command.automatic, command.seconds))
        case "pace":
            stage.keep_pace(command.speed)
        case "discard":
            stage.discard()
        case "undo":
            stage.undo()
        case "stop":
            stage.stop()


def _stage(stage: LiveStage) -> StageOut:
    return StageOut(
        id=stage.name,
        scene=stage.scene.name,
        view=f"/view/{stage.name}/",
        socket=f"/api/v1/stages/{stage.name}/socket",
    )
