"""Headless worlds of a studio: stepped by this program, request by request or through a stream."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray
from websockets.exceptions import InvalidStatus, WebSocketException
from websockets.sync.client import ClientConnection, connect

from evastudio.client.connection import NPZ, Connection, refused
from evastudio.errors import StudioError

Frame = Literal["world", "own"]
"""Whose frame actions are in: the world's, or that of the perception, as policies decide."""
FEW = 1000
"""So many numbers travel faster as JSON than as arrays."""
AHEAD = 16
"""Messages on their way through a stream."""


@dataclass(frozen=True)
class Seen:
    """All worlds as they are. Those that have ended stay as they ended."""

    states: NDArray[np.float64]
    """What is perceived, (worlds, n), or by everybody, (worlds, characters, n)."""
    outcomes: tuple[str, ...]
    """What has become of each."""
    progress: NDArray[np.float64]
    """How far each has come, 0 to 1, (worlds,)."""
    steps: NDArray[np.int64]
    """Decisions taken in each, (worlds,)."""
    ended: bool
    """Whether all have ended."""


class HeadlessWorlds:
    """Worlds of one scene, open in a studio until they are closed or left alone too long."""

    def __init__(self, connection: Connection, told: Mapping[str, Any]) -> None:
        self._connection = connection
        self._path = f"/worlds/{told['id']}"
        self.id: str = told["id"]
        self.scene: str = told["scene"]
        self.perception: str = told["perception"]
        self.seeds: tuple[int, ...] = tuple(told["seeds"])
        self.characters: int | None = told["characters"]
        """How many act in each world; None where one acts alone."""
        self.dt_s: float = told["dt_s"]
        """The decision step, seconds."""
        self.outcomes: tuple[str, ...] = tuple(told["outcomes"])
        """What can become of a world; the first while it runs."""
        self.state: tuple[str, ...] = tuple(told["state"])
        """Names of its components."""
        self.action: tuple[str, ...] = tuple(told["action"])
        """In the world's frame."""
        self.symbols: tuple[str, ...] = tuple(told["symbols"])
        """What codes of own actions mean; empty where they are numbers."""
        self._socket: str = told["socket"]

    def __enter__(self) -> HeadlessWorlds:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def observe(self) -> Seen:
        """How they are now."""
        return self._told("GET", "/state", None)

    def reset(self, seeds: Sequence[int]) -> Seen:
        """New worlds in place of these, of any number; a running take is kept as it is."""
        seen = self._told("POST", "/reset", {"seeds": list(seeds)})
        self.seeds = tuple(seeds)
        return seen

    def step(self, actions: ArrayLike, *, frame: Frame = "world") -> Seen:
        """One decision in every world, or several one after another.

        (worlds, m) or (steps, worlds, m); where many act (worlds, characters, m) or (steps,
        worlds, characters, m), or (worlds, m) for the leads alone while the others rest. Asked
        once only: where the answer is lost (UnreachableError), `observe` says whether it was done.
        """
        table = np.asarray(actions, dtype=np.float64)
        if max(table.size, self._size) <= FEW:
            return self._told("POST", "/step", {"actions": table.tolist()}, frame=frame)
        arrays = self._connection.arrays(
            "POST", f"{self._path}/step", {"actions": table}, frame=frame
        )
        return self._seen(arrays)

    def play(self, pilot: str, steps: int = 1) -> Seen:
        """Let a policy, or another pilot of the studio, decide for some steps; none is recorded."""
        return self._told("POST", "/play", {"pilot": pilot, "steps": steps})

    def save(self, *, fixed: bool = False) -> bytes:
        """Everything about them now, an npz file to `restore`; with `fixed` also what never
        changes in a world, and follows from its seed."""
        return self._connection.send("GET", f"{self._path}/snapshot", {"fixed": fixed}).content

    def restore(self, saved: bytes) -> Seen:
        """Go on from what was saved, of worlds of the same scene and options."""
        answer = self._connection.send(
            "PUT", f"{self._path}/snapshot", headers={"Content-Type": NPZ}, content=saved
        )
        self.seeds = tuple(self._connection.get(self._path)["seeds"])
        return self._from_json(answer.json())

    def stream(self, *, frame: Frame = "world") -> Stream:
        """A connection for many steps a second; use it in a `with` block."""
        return Stream(self, self._connection, self._socket, frame)

    def close(self) -> None:
        """Let go of them; a running take is kept, and is in the store."""
        self._connection.delete(self._path)

    @property
    def _size(self) -> int:
        """Numbers in the states of all worlds."""
        return len(self.seeds) * (self.characters or 1) * len(self.state)

    def _told(self, method: str, path: str, body: Any, **query: Any) -> Seen:
        answer = self._connection.send(method, self._path + path, query, json=body)
        return self._from_json(answer.json())

    def _from_json(self, told: Mapping[str, Any]) -> Seen:
        return Seen(
            np.asarray(told["states"], dtype=np.float64),
            tuple(told["outcomes"]),
            np.asarray(told["progress"], dtype=np.float64),
            np.asarray(told["steps"], dtype=np.int64),
            told["ended"],
        )

    def _seen(self, arrays: Mapping[str, NDArray[Any]]) -> Seen:
        codes = arrays["outcomes"]
        return Seen(
            arrays["states"],
            tuple(self.outcomes[code] for code in codes),
            arrays["progress"],
            arrays["steps"],
            bool(codes.all()),
        )

    def _from_rows(self, data: bytes) -> Seen:
        """What a binary message of the stream tells: outcome, progress, steps, states."""
        width = 3 + (self.characters or 1) * len(self.state)
        rows = np.frombuffer(data, dtype="<f8").reshape(-1, width)
        states = rows[:, 3:]
        if self.characters is not None:
            states = states.reshape(len(rows), self.characters, -1)
        return self._seen(
            {
                "states": states,
                "outcomes": rows[:, 0].astype(np.int64),
                "progress": rows[:, 1],
                "steps": rows[:, 2].astype(np.int64),
            }
        )


class Stream:
    """A websocket to headless worlds: a step costs little more than the scene itself takes."""

    def __init__(
        self, worlds: HeadlessWorlds, connection: Connection, path: str, frame: Frame
    ) -> None:
        self._worlds = worlds
        self._connection = connection
        self._url = f"ws{connection.base.removeprefix('http')}{path}?frame={frame}"
        self._socket: ClientConnection | None = None

    def __enter__(self) -> Stream:
        try:
            self._socket = connect(
                self._url,
                additional_headers=self._connection.headers,
                proxy=None,
                max_size=None,
                compression=None,
            )
        except InvalidStatus as error:
            raise _refused(error) from None
        except (OSError, WebSocketException) as error:
            raise self._connection.lost(error) from None
        return self

    def __exit__(self, *_: object) -> None:
        if self._socket is not None:
            self._socket.close()

    def step(self, actions: ArrayLike) -> Seen:
        """As `HeadlessWorlds.step`."""
        self._send(_bytes(actions))
        return self._receive()

    def steps(self, actions: Iterable[ArrayLike], ahead: int = AHEAD) -> Iterator[Seen]:
        """What follows each of `actions`, of which `ahead` are on their way before their answers.

        Much faster where actions do not depend on what was just seen. Actions are asked for that
        far ahead.
        """
        waiting = 0
        try:
            for one in actions:
                self._send(_bytes(one))
                waiting += 1
                if waiting >= ahead:
                    waiting -= 1
                    yield self._receive()
            while waiting:
                waiting -= 1
                yield self._receive()
        finally:  # a refusal, or who stopped listening: the next answer must be to the next message
            for _ in range(waiting):
                self._open.recv()

    def observe(self) -> Seen:
        """As `HeadlessWorlds.observe`."""
        return self._do(do="observe")

    def reset(self, seeds: Sequence[int]) -> Seen:
        """As `HeadlessWorlds.reset`."""
        seen = self._do(do="reset", seeds=list(seeds))
        self._worlds.seeds = tuple(seeds)
        return seen

    def play(self, pilot: str, steps: int = 1) -> Seen:
        """As `HeadlessWorlds.play`."""
        return self._do(do="play", pilot=pilot, steps=steps)

    def _do(self, **command: Any) -> Seen:
        self._send(json.dumps(command))
        return self._receive()

    def _send(self, message: str | bytes) -> None:
        try:
            self._open.send(message)
        except WebSocketException as error:
            raise self._connection.lost(error) from None

    def _receive(self) -> Seen:
        try:
            answer = self._open.recv()
        except WebSocketException as error:
            raise self._connection.lost(error) from None
        if isinstance(answer, bytes):
            return self._worlds._from_rows(answer)
        told = json.loads(answer)
        raise refused(told["status"], told["title"], told["detail"])

    @property
    def _open(self) -> ClientConnection:
        if self._socket is None:
            raise StudioError("The stream is not open; use it in a `with` block.")
        return self._socket


class Worlds:
    """`studio.worlds`."""

    def __init__(self, connection: Connection) -> None:
        self._connection = connection

    def __iter__(self) -> Iterator[HeadlessWorlds]:
        """Those that are open."""
        return (
            HeadlessWorlds(self._connection, told) for told in self._connection.pages("/worlds")
        )

    def get(self, worlds: str) -> HeadlessWorlds:
        """Those of that id. Raises NotFoundError."""
        return HeadlessWorlds(self._connection, self._connection.get(f"/worlds/{worlds}"))

    def open(
        self,
        scene: str,
        seeds: Sequence[int],
        *,
        options: Mapping[str, float] | None = None,
        perception: str | None = None,
        session: int | None = None,
        pilot: str = "program",
    ) -> HeadlessWorlds:
        """New worlds, one for each seed; use them in a `with` block.

        With a `session`, what this program does in the one world becomes its takes, by `pilot`.
        """
        body: dict[str, Any] = {
            "scene": scene,
            "seeds": list(seeds),
            "options": dict(options or {}),
            "pilot": pilot,
        }
        more = {"perception": perception, "session": session}
        body.update((name, value) for name, value in more.items() if value is not None)
        return HeadlessWorlds(self._connection, self._connection.post("/worlds", body))


def _bytes(actions: ArrayLike) -> bytes:
    return np.ascontiguousarray(actions, dtype="<f8").tobytes()


def _refused(error: InvalidStatus) -> StudioError:
    """The refusal of a websocket, with the studio's sentence where it says one."""
    response = error.response
    try:
        told = json.loads(response.body or b"")
        return refused(response.status_code, str(told["title"]), str(told["detail"]))
    except (ValueError, KeyError, TypeError):
        return refused(response.status_code, "", f"The studio refused the stream ({error}).")
