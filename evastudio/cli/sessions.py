"""Commands that make and list sessions."""

from __future__ import annotations

from typing import Annotated

import typer

from evastudio.cli.app import app
from evastudio.cli.options import (
    HERE,
    DensityOption,
    JsonFlag,
    OptionsOption,
    StoreOption,
    WorkspaceOption,
    options_of,
)
from evastudio.cli.showing import bar, show
from evastudio.workspace import Workspace


@app.command()
def record(
    scene: Annotated[str, typer.Argument(help="Name of a scene.")],
    pilot: Annotated[
        str, typer.Option(help="scripted:careful, scripted:human or scripted:keys.")
    ] = "scripted:careful",
    minutes: Annotated[float, typer.Option(help="How long it demonstrates.")] = 8.0,
    seed: Annotated[int, typer.Option(help="Decides every world.", min=0)] = 0,
    density: DensityOption = None,
    option: OptionsOption = None,
    session: Annotated[str | None, typer.Option(help="Name of the new session.")] = None,
    mark: Annotated[
        str | None, typer.Option(help="Mark when this condition begins or ceases to hold.")
    ] = None,
    workspace: WorkspaceOption = HERE,
    store: StoreOption = None,
    json_output: JsonFlag = False,
) -> None:
    """Let a scripted demonstrator record a session."""
    from evastudio.live import headless

    with bar(json_output) as progress:
        result = headless.record(
            Workspace(workspace, store),
            scene,
            pilot,
            minutes,
            seed,
            options=options_of(density, option),
            session=session,
            mark=mark,
            progress=progress,
        )
    show(result, json_output)


@app.command("import")
def import_walks(
    files: Annotated[
        list[str],
        typer.Argument(help="Tables of frame, person, x and y in metres; also in EVASTUDIO_DATA."),
    ],
    scene: Annotated[str, typer.Option(help="A scene in which people walk.")] = "street",
    session: Annotated[str | None, typer.Option(help="Name of the new session.")] = None,
    people: Annotated[int, typer.Option(help="Takes from each file, one a person.", min=1)] = 60,
    fps: Annotated[
        float | None, typer.Option(help="Frames a second, where the file does not say.")
    ] = None,
    credit: Annotated[
        str | None, typer.Option(help="Whom to credit, where the file does not say.")
    ] = None,
    workspace: WorkspaceOption = HERE,
    store: StoreOption = None,
    json_output: JsonFlag = False,
) -> None:
    """Make a session from recordings of people walking."""
    from evastudio.live.importing import import_walks

    with bar(json_output) as progress:
        result = import_walks(
            Workspace(workspace, store),
            files,
            scene=scene,
            session=session,
            people=people,
            fps=fps,
            credit=credit,
            progress=progress,
        )
    show(result, json_output)


@app.command()
def sessions(
    scene: Annotated[str | None, typer.Option(help="Only those of this scene.")] = None,
    workspace: WorkspaceOption = HERE,
    store: StoreOption = None,
    json_output: JsonFlag = False,
) -> None:
    """List the recorded sessions."""
    from evastudio.live import headless

    rows = headless.sessions(Workspace(workspace, store), scene)
    show(
        rows, json_output, ("id", "name", "scene", "demonstrator", "takes_kept", "pairs", "seconds")
    )
