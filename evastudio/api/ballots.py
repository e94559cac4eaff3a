"""Routes: ballots, two runs without names of which people choose the livelier."""

from __future__ import annotations

import asyncio
import time
from collections.abc import Mapping, Sequence

from fastapi import APIRouter, Response, status

from evastudio.api.context import Context, Studio
from evastudio.api.lineups import shown
from evastudio.api.models.ballots import BallotIn, BallotOut, PreferenceOut, VoteIn, VoteOut
from evastudio.api.models.common import Page
from evastudio.api.models.lineups import LineupOut
from evastudio.api.paging import NumberedPage
from evastudio.api.people import Person, Visitor
from evastudio.errors import ConflictError
from evastudio.evaluation import preferences
from evastudio.evaluation.preferences import Ballot
from evastudio.evaluation.studies import studies
from evastudio.evaluation.table_three import table_three
from evastudio.live import balloting
from evastudio.live.lineups import Opened
from evastudio.live.tokens import Role
from evastudio.world.loading import find_scenes

MARKDOWN = "text/markdown; charset=utf-8"

router = APIRouter(prefix="/ballots", tags=["ballots"])


@router.post("", status_code=status.HTTP_201_CREATED)
def open_ballot(body: BallotIn, studio: Studio, visitor: Visitor) -> BallotOut:
    """Ask people which of two pilots is livelier."""
    made = balloting.open_ballot(
        studio.workspace,
        studio.store,
        body.scene,
        body.pilots,
        options=body.options,
        seed=body.seed,
        now=time.time(),
    )
    return _told(made, studio, visitor, _titles(studio))


@router.get("")
def list_ballots(
    studio: Studio, visitor: Visitor, paging: NumberedPage, scene: str | None = None
) -> Page[BallotOut]:
    """Every ballot, the newest first; those of one scene where it is given. No names."""
    titles = _titles(studio)
    return paging.page(
        BallotOut,
        lambda after, limit: [
            _told(one, studio, visitor, titles)
            for one in preferences.ballots(studio.store, scene, after=after, limit=limit)
        ],
    )


@router.get("/preferences")
def list_preferences(studio: Studio, visitor: Visitor, paging: NumberedPage) -> Page[PreferenceOut]:
    """What came of the ballots, the newest first: to authors of all, to viewers of those they have
    voted on. A page holds fewer items than it may where nobody has voted yet."""
    found = preferences.ballots(studio.store, after=paging.cursor, limit=paging.limit + 1)
    page = found[: paging.limit]
    told = preferences.preferences(studio.store, _known(page, studio, visitor))
    items = [PreferenceOut.model_validate(one) for one in reversed(told)]
    return Page(items=items, next=page[-1].id if len(found) > paging.limit else None)


@router.get(
    "/table-3", response_class=Response, responses={200: {"content": {"text/markdown": {}}}}
)
def get_table(studio: Studio, visitor: Visitor) -> Response:
    """The paper's table 3, with the studies stored and what came of the ballots, as Markdown."""
    ballots = _known(preferences.ballots(studio.store), studio, visitor)
    found = preferences.preferences(studio.store, ballots)
    table = "\n".join(table_three(studies(studio.store), found)) + "\n"
    named = {"Content-Disposition": 'attachment; filename="table-3.md"'}
    return Response(table, media_type=MARKDOWN, headers=named)


@router.get("/{ballot:int}")
def get_ballot(ballot: int, studio: Studio, visitor: Visitor) -> BallotOut:
    """One ballot. No names."""
    return _told(preferences.find_ballot(studio.store, ballot), studio, visitor, _titles(studio))


@router.get("/{ballot:int}/preference")
def get_preference(ballot: int, studio: Studio, visitor: Visitor) -> PreferenceOut:
    """What came of a ballot so far; told to a viewer who has voted on it."""
    found = preferences.find_ballot(studio.store, ballot)
    if not _may_know(found, studio, visitor):
        raise ConflictError("Vote first: what came of it would tell who is who.")
    return PreferenceOut.model_validate(preferences.preference(studio.store, found))


@router.post("/{ballot:int}/showings", status_code=status.HTTP_201_CREATED)
async def show_pair(ballot: int, studio: Studio, visitor: Visitor) -> LineupOut:
    """The two side by side, in the next world that one has not voted on: a lineup, no names.

    Who is left follows from a secret of the ballot's, and is the same until one has voted.
    """

    def show() -> Opened:
        return balloting.show(
            studio.workspace,
            studio.lineups,
            studio.store,
            preferences.find_ballot(studio.store, ballot),
            visitor.voter,
        )

    return await shown(await asyncio.to_thread(show), studio)


@router.post("/{ballot:int}/votes", status_code=status.HTTP_201_CREATED)
def vote(ballot: int, body: VoteIn, studio: Studio, visitor: Visitor) -> VoteOut:
    """Say which of the two that were shown was livelier; who they were."""
    found = preferences.find_ballot(studio.store, ballot)
    opened = studio.lineups.get(visitor.voter, body.lineup)
    left, right = balloting.vote(studio.store, found, opened, body.livelier, time.time())
    return VoteOut(
        left=left,
        right=right,
        livelier={"left": left, "right": right}.get(body.livelier),
        preference=PreferenceOut.model_validate(preferences.preference(studio.store, found)),
    )


@router.delete("/{ballot:int}", status_code=status.HTTP_204_NO_CONTENT)
def delete_ballot(ballot: int, studio: Studio) -> None:
    """Forget a ballot and its votes."""
    preferences.delete_ballot(studio.store, ballot)


def _may_know(ballot: Ballot, studio: Context, visitor: Person) -> bool:
    """Whether somebody may know who is in a ballot: its authors do, others once they voted."""
    return visitor.role is Role.AUTHOR or bool(
        preferences.votes_of(studio.store, ballot.id, visitor.voter)
    )


def _known(ballots: Sequence[Ballot], studio: Context, visitor: Person) -> list[Ballot]:
    """Those of `ballots` of which somebody may know who is in them."""
    return [one for one in ballots if _may_know(one, studio, visitor)]


def _titles(studio: Context) -> Mapping[str, str]:
    """Of every scene that is there, by its name."""
    scenes = find_scenes(studio.workspace.scene_folders)
    return {name: scene.title for name, scene in scenes.items()}


def _told(ballot: Ballot, studio: Context, visitor: Person, titles: Mapping[str, str]) -> BallotOut:
    found = preferences.preference(studio.store, ballot)
    return BallotOut(
        id=ballot.id,
        scene=ballot.scene,
        title=titles.get(ballot.scene, ballot.scene),
        created_at=ballot.created_at,
        votes=found.decided + found.neither,
        mine=preferences.votes_of(studio.store, ballot.id, visitor.voter),
    )
