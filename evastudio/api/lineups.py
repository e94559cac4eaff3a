"""Routes: lineups, runs of one world side by side."""

from __future__ import annotations

import asyncio
import time

from fastapi import APIRouter, status

from evastudio.api.context import Context, Studio
from evastudio.api.models.common import Page
from evastudio.api.models.lineups import (
    ColumnOut,
    HappeningOut,
    LineupCommandIn,
    LineupIn,
    LineupOut,
    StandingOut,
)
from evastudio.api.paging import NamedPage
from evastudio.api.people import Visitor
from evastudio.live.lineup import Column, Lineup, Standing
from evastudio.live.lineups import IDLE_S, Entrant, Opened, World

router = APIRouter(prefix="/lineups", tags=["lineups"])


@router.post("", status_code=status.HTTP_201_CREATED)
async def open_lineup(body: LineupIn, studio: Studio, visitor: Visitor) -> LineupOut:
    """Fly two to four through the same world, to be looked at side by side.

    It closes itself when nobody looks at it for a minute.
    """
    world = World(body.scene, body.options, body.seed, body.world)
    entrants = [Entrant(one.pilot, one.take) for one in body.entrants]
    opened = await asyncio.to_thread(studio.lineups.open, visitor.voter, world, entrants)
    return await shown(opened, studio)


@router.get("")
def list_lineups(studio: Studio, visitor: Visitor, paging: NamedPage) -> Page[LineupOut]:
    """One's own that are open, the first opened first."""
    return paging.page(
        studio.lineups.all(visitor.voter),
        lambda opened: opened.lineup.name,
        lambda opened: _told(opened, opened.lineup.standing()),
    )


@router.get("/{lineup}")
async def get_lineup(lineup: str, studio: Studio, visitor: Visitor) -> LineupOut:
    """One of one's own."""
    opened = studio.lineups.get(visitor.voter, lineup)
    return _told(opened, await asyncio.to_thread(opened.lineup.standing))


@router.get("/{lineup}/standing")
def get_standing(lineup: str, studio: Studio, visitor: Visitor) -> StandingOut:
    """Where it is now."""
    found = studio.lineups.get(visitor.voter, lineup).lineup
    return StandingOut.model_validate(found.standing())


@router.post("/{lineup}/commands")
def command_lineup(
    lineup: str, body: LineupCommandIn, studio: Studio, visitor: Visitor
) -> StandingOut:
    """Go somewhere in all columns at once; where it then is."""
    found = studio.lineups.get(visitor.voter, lineup).lineup
    return StandingOut.model_validate(_perform(found, body))


@router.delete("/{lineup}", status_code=status.HTTP_204_NO_CONTENT)
async def close_lineup(lineup: str, studio: Studio, visitor: Visitor) -> None:
    """Close one of one's own."""
    await _close(studio.lineups.get(visitor.voter, lineup).lineup, studio)


def _perform(lineup: Lineup, command: LineupCommandIn) -> Standing:
    match command.name:
        case "seek":
            return lineup.seek(command.seconds)
        case "roll":
            return lineup.roll(command.speed)
        case "camera":
            return lineup.look_through(command.camera)


async def shown(opened: Opened, studio: Context) -> LineupOut:
    """A lineup that was just opened, as it is told; it is closed once nobody looks at it."""
    studio.background(_close_when_idle(opened.lineup, studio))
    return _told(opened, await asyncio.to_thread(opened.lineup.standing))


async def _close_when_idle(lineup: Lineup, studio: Context) -> None:
    while (left := IDLE_S - lineup.idle_s(time.monotonic())) > 0.0:
        await asyncio.sleep(left)
    await _close(lineup, studio)


async def _close(lineup: Lineup, studio: Context) -> None:
    await asyncio.to_thread(studio.lineups.close, lineup.name)
    for column in lineup.columns:
        for hook in studio.stage_closed:
            hook(column.name)


def _told(opened: Opened, standing: Standing) -> LineupOut:
    lineup = opened.lineup
    return LineupOut(
        id=lineup.name,
        scene=lineup.scene.name,
        dt_s=lineup.scene.dt_s,
        length_s=lineup.length_s,
        parts_s=lineup.parts_s,
        cameras=lineup.cameras,
        columns=[_column(column) for column in lineup.columns],
        options=dict(lineup.scene.values),
        world=opened.world.number,
        ballot=opened.ballot,
        standing=StandingOut.model_validate(standing),
    )


def _column(column: Column) -> ColumnOut:
    outcome = column.outcome
    return ColumnOut(
        view=f"/view/{column.name}/",
        title=column.title,
        length_s=column.length_s,
        outcome=outcome,
        success=None if outcome is None else outcome in column.scene.successes,
        parts_s=column.parts_s,
        happenings=[HappeningOut.model_validate(one) for one in column.happenings],
    )
