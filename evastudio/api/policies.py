"""Routes: the policies at hand."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from fastapi import APIRouter

from evastudio.api.context import Studio
from evastudio.api.models.common import Page
from evastudio.api.models.policies import PolicyOut
from evastudio.api.paging import NamedPage
from evastudio.errors import NotFoundError, StorageError, not_found
from evastudio.learning.catalog import PolicyEntry, list_policies
from evastudio.live import piloting
from evastudio.live.age import made_before
from evastudio.live.headless import make_scene
from evastudio.world.scene import Scene

router = APIRouter(prefix="/policies", tags=["policies"])


@router.get("")
def list_all_policies(
    studio: Studio, paging: NamedPage, scene: str | None = None
) -> Page[PolicyOut]:
    """Policies of the workspace and shipped ones; those of one scene where it is given.

    Files that cannot be read are listed with what is wrong, whatever the scene.
    """
    entries = list_policies(studio.workspace.policy_folders).values()
    items = [_policy(entry, studio) for entry in entries]
    wanted = [item for item in items if scene is None or item.scene in (scene, None)]
    return paging.page(wanted, lambda one: one.name, lambda one: one)


@router.get("/{name}")
def get_policy(name: str, studio: Studio) -> PolicyOut:
    """One policy."""
    return described(name, studio)


def described(name: str, studio: Studio) -> PolicyOut:
    """A policy by name. Raises NotFoundError."""
    entries = list_policies(studio.workspace.policy_folders)
    if name not in entries:
        raise not_found("policy", name, entries)
    return _policy(entries[name], studio)


def _policy(entry: PolicyEntry, studio: Studio) -> PolicyOut:
    try:
        return _described(entry, entry.header or {}, studio)
    except StorageError:  # not the file's fault
        raise
    except (TypeError, ValueError, AttributeError, LookupError, OverflowError):
        problem = f"{entry.path} is not a policy that can be used: its description is not whole."
        return _described(replace(entry, problem=problem), {}, studio)


def _described(entry: PolicyEntry, header: Mapping[str, Any], studio: Studio) -> PolicyOut:
    scene: Mapping[str, Any] = header.get("scene") or {}
    extra: Mapping[str, Any] = header.get("extra") or {}
    now, problem = _mismatch(scene, studio) if entry.problem is None else (None, entry.problem)
    report, changed = _report(extra), made_before(header, studio.store)
    in_short = _report({**extra, "findings": extra.get("in_short", extra.get("findings"))})
    if entry.switch is not None and now is not None:
        known = list_policies(studio.workspace.policy_folders)
        problem = problem or piloting.cannot_play(entry.switch, now, known)
        report = in_short = [] if problem else [entry.switch.words(now)]
    return PolicyOut(
        name=entry.name,
        scene=scene.get("name"),
        scene_version=scene.get("version"),
        perception=header.get("perception"),
        learner=header.get("learner"),
        settings=header.get("settings") or {},
        pairs=header.get("pairs"),
        session=extra.get("session_name"),
        report=report,
        in_short=in_short,
        switches=[] if entry.switch is None else list(entry.switch.policies),
        made_by=header.get("made_by"),
        created=header.get("created"),
        shipped=entry.path.parent.resolve() != studio.workspace.policies.resolve(),
        stale=changed is not None,
        made_before=changed,
        problem=problem,
    )


def _report(extra: Mapping[str, Any]) -> list[str]:
    """What fitting found that its user should read."""
    delay = extra.get("delay") or {}
    told = [delay["sentence"]] if delay.get("steps") else []
    return (
        told + (extra.get("findings") or []) + ((extra.get("tuning") or {}).get("sentences") or [])
    )


def _mismatch(scene: Mapping[str, Any], studio: Studio) -> tuple[Scene | None, str | None]:
    """The scene as it is now, and why what was made for `scene` cannot play in it, or None."""
    try:
        now = make_scene(studio.workspace, str(scene.get("name")))
    except NotFoundError as error:
        return None, str(error)
    if scene.get("version") != now.version:
        return now, (
            f"It was made for version {scene.get('version')} of the scene, which is now version "
            f"{now.version}. Fit it again."
        )
    return now, None
