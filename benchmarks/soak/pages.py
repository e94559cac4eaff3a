"""Pages without a browser, in a process of their own: they drive stages with random keys.

Each holds keys that a seed decides, demonstrates until the time is up, again and again, and writes
down how many pairs its stage said each take has. What it was told is printed as JSON.
"""

from __future__ import annotations

import asyncio
import contextlib
import json
import random
import subprocess
import sys
import time
from collections.abc import Sequence
from dataclasses import asdict, dataclass, field
from typing import Any

from websockets.asyncio.client import ClientConnection, connect

CODES = ("KeyA", "KeyD", "KeyW", "KeyS", "ArrowLeft", "ArrowRight", "ArrowUp", "ArrowDown")
KEYS_HZ = 4.0
"""How often, on average, a page tells other keys."""
COMING_S = 10.0
"""Each page begins at a moment of its own within this time, as people do."""
END_S = 30.0
"""So long a page waits for its stage to stop."""


@dataclass(frozen=True)
class Stage:
    """What a page needs of a stage to drive it."""

    socket: str
    """Whole address of its websocket."""
    view: str | None
    """Address of the 3D view, where the page looks at it too."""
    subprotocol: str


@dataclass
class Told:
    """What a page was told."""

    takes: list[int] = field(default_factory=list)
    """Pairs of each take, in order."""
    messages: int = 0
    view_bytes: int = 0
    notices: list[str] = field(default_factory=list)


def drive(token: str, stages: Sequence[Stage], seconds: float, seed: int) -> subprocess.Popen[str]:
    """Begin to drive `stages`; `told` waits for the end."""
    asked = {
        "token": token,
        "stages": [asdict(stage) for stage in stages],
        "seconds": seconds,
        "seed": seed,
    }
    command = [sys.executable, "-m", "benchmarks.soak.pages"]
    process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
    assert process.stdin is not None
    json.dump(asked, process.stdin)
    process.stdin.close()
    return process


def told(process: subprocess.Popen[str]) -> list[Told]:
    """What each page was told, once all have ended."""
    assert process.stdout is not None
    with process.stdout as output:
        found = json.load(output)
    if process.wait() != 0:
        raise RuntimeError("The pages ended with an error; see above.")
    return [Told(**one) for one in found]


async def one_page(stage: Stage, headers: dict[str, str], seconds: float, seed: int) -> Told:
    found = Told()
    rng = random.Random(seed)
    async with contextlib.AsyncExitStack() as opened:
        options: dict[str, Any] = {"additional_headers": headers, "proxy": None, "max_size": None}
        socket = await opened.enter_async_context(connect(stage.socket, **options))
        tasks = [asyncio.create_task(hold_keys(socket, rng))]
        if stage.view is not None:
            protocols = [stage.subprotocol]
            view = connect(stage.view, subprotocols=protocols, **options)  # type: ignore[arg-type]
            seeing = await opened.enter_async_context(view)
            tasks.append(asyncio.create_task(look(seeing, found)))
        try:
            waited_s = rng.uniform(0.0, COMING_S if seconds > COMING_S else 0.0)
            await asyncio.sleep(waited_s)
            await demonstrate(socket, found, seconds - waited_s)
        finally:
            for task in tasks:
                task.cancel()
            await asyncio.gather(*tasks, return_exceptions=True)
    return found


async def demonstrate(socket: ClientConnection, found: Told, seconds: float) -> None:
    until = time.monotonic() + seconds
    stopping = False
    phase = ""
    await command(socket, "demonstrate")
    async with asyncio.timeout(seconds + END_S):
        while True:
            message = json.loads(await socket.recv())
            found.messages += 1
            if message["type"] == "notice":
                found.notices.append(message["text"])
            if message["type"] != "status":
                continue
            before, phase = phase, message["phase"]
            if before == "recording" and phase != "recording":
                found.takes.append(message["pairs"])
                if not stopping:
                    await command(socket, "restart")
            if stopping and phase == "ready":
                return
            if time.monotonic() >= until and not stopping:
                stopping = True
                await command(socket, "stop")


async def command(socket: ClientConnection, name: str) -> None:
    await socket.send(json.dumps({"type": "command", "name": name}))


async def hold_keys(socket: ClientConnection, rng: random.Random) -> None:
    while True:
        await asyncio.sleep(rng.expovariate(KEYS_HZ))
        held = rng.sample(CODES, rng.randint(0, 2))
        keys = {"type": "keys", "held": held, "time_ms": time.time() * 1000.0}
        await socket.send(json.dumps(keys))


async def look(seeing: ClientConnection, found: Told) -> None:
    async for message in seeing:
        found.view_bytes += len(message)


async def main() -> None:
    asked = json.load(sys.stdin)
    headers = {"Authorization": f"Bearer {asked['token']}"}
    pages = [
        one_page(Stage(**stage), headers, asked["seconds"], 1000 * asked["seed"] + number)
        for number, stage in enumerate(asked["stages"])
    ]
    json.dump([asdict(one) for one in await asyncio.gather(*pages)], sys.stdout)


if __name__ == "__main__":
    asyncio.run(main())
