"""Commands that keep a workspace safe."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from evastudio.cli.app import app
from evastudio.cli.options import HERE, JsonFlag, StoreOption, WorkspaceOption
from evastudio.cli.showing import bar, show
from evastudio.workspace import Workspace


@app.command()
def backup(
    file: Annotated[Path, typer.Argument(help="The new file.")],
    workspace: WorkspaceOption = HERE,
    store: StoreOption = None,
    json_output: JsonFlag = False,
) -> None:
    """Write all sessions, policies, scenes and clips into one file, while the studio runs."""
    from evastudio.live import backups

    with bar(json_output) as progress:
        result = backups.backup(Workspace(workspace, store), file, progress=progress)
    show(result, json_output)


@app.command()
def restore(
    file: Annotated[Path, typer.Argument(help="What `evastudio backup` wrote.")],
    workspace: WorkspaceOption = HERE,
    store: StoreOption = None,
    json_output: JsonFlag = False,
) -> None:
    """Put a backup into a new workspace, of any database; nothing that is there is written over.

    A backup holds scenes, and scenes are programs: restore only what you trust.
    """
    from evastudio.live import backups

    with bar(json_output) as progress:
        result = backups.restore(Workspace(workspace, store), file, progress=progress)
    show(result, json_output)
