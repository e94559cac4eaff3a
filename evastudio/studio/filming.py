"""Filming: a run made into one file to hand on, a page that plays it in 3D or a video."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from evastudio.learning.cleaning import Progress, silent
from evastudio.live.films import SIZE, Form, check
from evastudio.live.footage import Footage
from evastudio.workspace import Workspace
from evastudio.writing import write_whole


def film(
    workspace: Workspace,
    footage: Footage,
    form: str = Form.PAGE,
    size: tuple[int, int] = SIZE,
    out: Path | None = None,
    progress: Progress = silent,
) -> dict[str, Any]:
    """Make `footage` into a file, `out` or one of the workspace's films: a job.

    `size` is a video's width and height. Raises ConflictError where PyAV is needed and not
    installed, InvalidInputError for a size that cannot be.
    """
    check(form, size)
    progress(0.0, "Setting the scene")
    reel = footage.reel(workspace)
    if form == Form.VIDEO:
        from evastudio.studio.video import video  # loads the compiler

        made = video(reel, footage.camera, size, progress=progress)
    else:
        from evastudio.studio.recorded import recorded

        made = recorded(reel, footage.camera, footage.title, progress=progress)
    path = write_whole(out or workspace.films / f"{footage.name}.{form}", made)
    seconds = (footage.moments - 1) * reel.scene.dt_s
    return {"film": path.name if out is None else str(path), "bytes": len(made), "seconds": seconds}
