"""A slow page misses what the next message tells anyway, and no job or notice."""

from __future__ import annotations

import asyncio

from evastudio.api.outbox import WAITING, Outbox


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


def test_notices_without_end_are_bounded_too() -> None:
    async def waiting() -> tuple[int, int]:
        box = Outbox()
        for seq in range(2 * WAITING):
            box.put({"type": "notice", "seq": seq})
        return len(box), (await box.get())["seq"]

    assert asyncio.run(waiting()) == (WAITING, WAITING)
