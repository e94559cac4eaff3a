"""A stage closes when nobody drives it, and not before."""

from __future__ import annotations

import asyncio
from collections.abc import Iterator

import pytest

from evastudio.api import attendance
from evastudio.api.attendance import Attendance
from evastudio.demonstrations.store import Store
from evastudio.live.live_stage import LiveStage
from evastudio.live.stages import Stages
from evastudio.workspace import Workspace


@pytest.fixture
def stage(workspace: Workspace, store: Store) -> Iterator[LiveStage]:
    stages = Stages(workspace, store)
    yield stages.open("asteroids", seed=1)
    stages.close_all()


@pytest.fixture(autouse=True)
def at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(attendance, "IDLE_S", 0.0)


async def closed(*, end: bool = False, come: bool = False, stage: LiveStage) -> bool:
    """Whether the stage is closed when the loop has done all that is due."""
    told = asyncio.Event()
    watched = Attendance(stage, told.set)
    if come:
        watched.came()
        watched.seen()
    if end:
        watched.end()
    for _ in range(5):
        await asyncio.sleep(0)
    return told.is_set()


def test_a_stage_nobody_drives_is_closed(stage: LiveStage) -> None:
    assert asyncio.run(closed(stage=stage))


def test_a_stage_with_a_page_stays(stage: LiveStage) -> None:
    assert not asyncio.run(closed(come=True, stage=stage))


def test_a_stage_closed_by_hand_is_not_closed_again(stage: LiveStage) -> None:
    assert not asyncio.run(closed(end=True, stage=stage))


def test_a_command_without_a_page_puts_the_closing_off(
    stage: LiveStage, monkeypatch: pytest.MonkeyPatch
) -> None:
    async def command() -> bool:
        told = asyncio.Event()
        watched = Attendance(stage, told.set)
        monkeypatch.setattr(attendance, "IDLE_S", 3600.0)
        watched.seen()
        for _ in range(5):
            await asyncio.sleep(0)
        watched.end()
        return told.is_set()

    assert not asyncio.run(command())
