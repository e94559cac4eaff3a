"""The doctor: what is wrong with a workspace, in plain sentences, and what can be mended.

It never deletes what a person made: what is broken is moved into the folder `aside`, and a damaged
take goes to the trash.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import replace

from evastudio.errors import StudioError
from evastudio.live.doctor.files import look_at_files
from evastudio.live.doctor.finding import Finding
from evastudio.live.doctor.folder import look_at_folder
from evastudio.live.doctor.stored import look_at_store
from evastudio.workspace import Workspace

__all__ = ["Finding", "examine"]


def examine(
    workspace: Workspace, mend: bool = False, clock: Callable[[], float] = time.time
) -> list[Finding]:
    """Everything that was found; with `mend` what can be mended is."""
    found: list[Finding] = []
    for look in (look_at_folder, look_at_store, look_at_files):
        for finding in look(workspace, clock()):
            found.append(_mended(finding) if mend and finding.cure is not None else finding)
    return found


def _mended(finding: Finding) -> Finding:
    assert finding.cure is not None
    try:
        finding.cure()
    except (StudioError, OSError) as error:
        return replace(finding, problem=f"{finding.problem} It could not be mended: {error}")
    return replace(finding, mended=True)
