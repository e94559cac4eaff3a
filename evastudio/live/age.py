"""How a session has changed since a policy was fitted to it, in words."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from evastudio.demonstrations.records import CleaningRecord
from evastudio.demonstrations.store import Store
from evastudio.errors import NotFoundError


def made_before(header: Mapping[str, Any], store: Store) -> str | None:
    """What the policy of that file header was made before: "made before 2 takes were added".

    None where nothing has changed, or its session is in another store.
    """
    extra: Mapping[str, Any] = header.get("extra") or {}
    if extra.get("store") != store.identity:
        return None
    try:
        session = store.session(int(header.get("session") or 0))
    except NotFoundError:
        return "made before its session was deleted"
    before = set(header.get("takes") or ())
    now = {take.id: take.pairs for take in store.takes(session.id) if take.pairs}
    changes = []
    for takes, what in ((now.keys() - before, "added"), (before - now.keys(), "thrown away")):
        if takes:
            count = "1 take was" if len(takes) == 1 else f"{len(takes)} takes were"
            changes.append(f"{count} {what}")
    if not changes and session.pairs != extra.get("pairs_before_cleaning"):
        changes.append("its takes were changed")
    cleaned = _cleaned(extra.get("cleaning_id"), header.get("cleaning"), session.cleaning)
    changes += [] if cleaned is None else [cleaned]
    return f"made before {' and '.join(changes)}" if changes else None


def _cleaned(was: Any, settings: Any, now: CleaningRecord | None) -> str | None:
    """How the cleaning in force is another than the one with the id `was` and those settings."""
    if now is None:
        return None if was is None else "a cleaning was taken back"
    if now.id == was:
        return None
    by_hand = int(now.settings.get("by_hand", 0)) - int((settings or {}).get("by_hand", 0))
    rest = {name: value for name, value in now.settings.items() if name not in _BY_HAND}
    same = rest == {name: value for name, value in (settings or {}).items() if name not in _BY_HAND}
    if same and by_hand > 0:
        count = "1 moment was" if by_hand == 1 else f"{by_hand} moments were"
        return f"{count} left out by hand"
    return "the takes were cleaned" if was is None else "the takes were cleaned anew"


_BY_HAND = ("by_hand", "moment")
