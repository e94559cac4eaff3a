"""A slow page misses what the next message tells anyway, and no job or notice."""

from __future__ import annotations

import asyncio
from collections import Counter
from concurrent.futures import ThreadPoolExecutor

from evastudio.api.outbox import WAITING, Outbox, Post


def test_messages_come_in_order() -> None:
    async def told() -> list[int]:
        box = Outbox()
        first = asyncio.create_task(box.get())
        await asyncio.sleep(0)
        for seq in range(3):
            box.put({"type": "ack", "seq": seq})
        return [(await first)["seq"], (await box.get())["seq"], (await box.get())["seq"]]

    assert asyncio.run(told()) == [0, 1, 2]


def test_a_flood_of_what_passes_drops_no_job_and_no_notice() -> None:
    async def told() -> list[tuple[str, int]]:
        box = Outbox()
        box.put({"type": "job", "seq": 0})
        box.put({"type": "notice", "seq": 0})
        for seq in range(10 * WAITING):
            box.put({"type": ("ack", "status")[seq % 2], "seq": seq})
        assert len(box) == WAITING
        got = [await box.get() for _ in range(WAITING)]
        return [(one["type"], one["seq"]) for one in got]

    kept = asyncio.run(told())
    assert kept[:2] == [("job", 0), ("notice", 0)]
    assert kept[-1] == ("status", 10 * WAITING - 1)


def test_what_many_threads_tell_arrives_whole_and_each_ones_in_order() -> None:
    async def told() -> list[list[int]]:
        boxes, post = [Outbox() for _ in range(8)], Post()

        def tell(box: Outbox) -> None:
            for seq in range(WAITING):
                post.tell(box, {"type": "status", "seq": seq})

        loop = asyncio.get_running_loop()
        with ThreadPoolExecutor(len(boxes)) as threads:
            await asyncio.gather(*(loop.run_in_executor(threads, tell, box) for box in boxes))
        return [[(await box.get())["seq"] for _ in range(WAITING)] for box in boxes]

    assert asyncio.run(told()) == [list(range(WAITING))] * 8


def test_the_loop_is_woken_once_for_all_that_it_has_not_fetched() -> None:
    async def woken() -> int:
        loop, calls = asyncio.get_running_loop(), Counter[str]()
        box, post = Outbox(), Post()
        wake = loop.call_soon_threadsafe

        def counted(*given: object) -> object:
            calls["woken"] += 1
            return wake(*given)  # type: ignore[arg-type]

        loop.call_soon_threadsafe = counted  # type: ignore[assignment,method-assign]
        for _ in range(3):
            for seq in range(5):
                post.tell(box, {"type": "ack", "seq": seq})
            for _ in range(5):
                await box.get()
        return calls["woken"]

    assert asyncio.run(woken()) == 3


def test_notices_without_end_are_bounded_too() -> None:
    async def waiting() -> tuple[int, int]:
        box = Outbox()
        for seq in range(2 * WAITING):
            box.put({"type": "notice", "seq": seq})
        return len(box), (await box.get())["seq"]

    assert asyncio.run(waiting()) == (WAITING, WAITING)
