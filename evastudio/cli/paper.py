"""The commands that measure the paper's tables here."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from evastudio.cli.app import app
from evastudio.cli.options import (
    HERE,
    ClusterOption,
    JobsOption,
    JsonFlag,
    StoreOption,
    WorkspaceOption,
)
from evastudio.cli.showing import bar, show
from evastudio.workspace import Workspace


@app.command()
def paper(
    quick: Annotated[bool, typer.Option("--quick", help="A few minutes, fewer fields.")] = False,
    out: Annotated[Path, typer.Option(help="Folder for the tables and pictures.")] = Path("paper"),
    jobs: JobsOption = 1,
    cluster: ClusterOption = None,
    workspace: WorkspaceOption = HERE,
    store: StoreOption = None,
    json_output: JsonFlag = False,
) -> None:
    """Measure the paper's tables here, beside the paper's own numbers, with pictures."""
    from evastudio.live import reproducing

    with bar(json_output) as progress:
        result = reproducing.paper(
            Workspace(workspace, store),
            out,
            quick=quick,
            jobs=jobs,
            cluster=cluster,
            progress=progress,
        )
    if json_output:
        show(result, True)
    else:
        print((out / "paper.md").read_text(encoding="utf-8"))


@app.command()
def studies(
    forget: Annotated[int | None, typer.Option(help="Delete the study of this id.")] = None,
    workspace: WorkspaceOption = HERE,
    store: StoreOption = None,
    json_output: JsonFlag = False,
) -> None:
    """List how long people were taught and demonstrated, who agreed that it is kept."""
    from evastudio.live import studying

    found = studying.studies(Workspace(workspace, store), forget=forget)
    columns = ("id", "scene", "person", "instructed_s", "demonstrated_s", "preferred")
    show(found, json_output, columns)
