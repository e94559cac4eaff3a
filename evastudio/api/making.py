"""Routes: sessions and policies made with nobody at the keys. Each is a job."""

from __future__ import annotations

from functools import partial

from fastapi import APIRouter, status

from evastudio.api.context import Studio
from evastudio.api.models.jobs import JobOut
from evastudio.api.models.policies import SwitchIn
from evastudio.api.models.searches import SearchIn
from evastudio.api.models.sessions import ImportIn, RecordIn
from evastudio.learning.catalog import checked_policy_name
from evastudio.live import headless, switching
from evastudio.live.importing import import_walks
from evastudio.live.searching import search
from evastudio.live.walk_files import walk_file
from evastudio.pilots.pegasus import Pegasus
from evastudio.pilots.scripted import find_pilot
from evastudio.world.conditions import parse_condition
from evastudio.world.loading import find_scene

router = APIRouter(tags=["making"])


@router.post("/demonstrations", status_code=status.HTTP_202_ACCEPTED)
def demonstrate(body: RecordIn, studio: Studio) -> JobOut:
    """Let a scripted demonstrator record a new session; a job whose result names it."""
    scene = headless.make_scene(studio.workspace, body.scene, body.options)
    find_pilot(body.pilot)
    if body.mark is not None:
        parse_condition(body.mark, scene)
    job = studio.jobs.submit(
        "record",
        partial(headless.record, session=body.session),
        workspace=studio.workspace,
        **body.model_dump(exclude={"session"}),
    )
    return JobOut.model_validate(job)


@router.post("/imports", status_code=status.HTTP_202_ACCEPTED)
def start_import(body: ImportIn, studio: Studio) -> JobOut:
    """Make a session of recordings of people walking (`/walks`); a job whose result names it."""
    find_scene(body.scene, studio.workspace.scene_folders)
    files = [str(walk_file(studio.workspace, name)) for name in body.files]
    job = studio.jobs.submit(
        "import",
        partial(import_walks, session=body.session),
        workspace=studio.workspace,
        files=files,
        **body.model_dump(exclude={"files", "session"}),
    )
    return JobOut.model_validate(job)


@router.post("/searches", status_code=status.HTTP_202_ACCEPTED)
def start_search(body: SearchIn, studio: Studio) -> JobOut:
    """Search for a policy with no demonstration (PEGASUS); a job whose result names it."""
    settings = body.model_dump(exclude={"scene", "perception", "options", "name"})
    name = checked_policy_name(body.name or f"pegasus-{body.seed}")
    scene = headless.make_scene(studio.workspace, body.scene, body.options)
    job = studio.jobs.submit(
        "search",
        search,
        workspace=studio.workspace,
        scene=body.scene,
        settings=Pegasus(**settings),
        perception=scene.perception(body.perception).name,
        options=body.options,
        name=name,
    )
    return JobOut.model_validate(job)


@router.post("/switches", status_code=status.HTTP_202_ACCEPTED)
def make_switch(body: SwitchIn, studio: Studio) -> JobOut:
    """Make a switch between policies, by written conditions or learned ones; a job."""
    job = studio.jobs.submit(
        "switch",
        switching.switch,
        workspace=studio.workspace,
        name=checked_policy_name(body.name),
        entries=[(entry.policy, entry.when) for entry in body.entries],
        perception=body.perception,
    )
    return JobOut.model_validate(job)
