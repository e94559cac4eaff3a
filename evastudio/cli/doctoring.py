"""The command that looks after a workspace."""

from __future__ import annotations

from typing import Annotated

import typer

from evastudio.cli.app import app
from evastudio.cli.options import HERE, JsonFlag, StoreOption, WorkspaceOption
from evastudio.cli.showing import show
from evastudio.workspace import Workspace


@app.command()
def doctor(
    mend: Annotated[bool, typer.Option("--mend", help="Mend what can be mended.")] = False,
    workspace: WorkspaceOption = HERE,
    store: StoreOption = None,
    json_output: JsonFlag = False,
) -> None:
    """Say what is wrong with a workspace, and mend it with --mend; exit code 1 if anything is."""
    from evastudio.live.doctor import examine

    found = examine(Workspace(workspace, store), mend)
    if json_output:
        show([finding.to_json() for finding in found], True)
    elif not found:
        print("Nothing is wrong.")
    for finding in [] if json_output else found:
        print(f"{finding.about}\n    {finding.problem}")
        if finding.mend is not None:
            print(f"    {'Done' if finding.mended else 'With --mend'}: {finding.mend}")
    if any(finding.wrong and not finding.mended for finding in found):
        raise typer.Exit(1)
