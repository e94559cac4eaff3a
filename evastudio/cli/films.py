"""The command that makes files of takes and of what policies do, to be handed on."""

from __future__ import annotations

from pathlib import Path
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
from evastudio.errors import InvalidInputError
from evastudio.workspace import Workspace


@app.command()
def film(
    out: Annotated[Path, typer.Argument(help="File to write: .html plays anywhere, .mp4 a video.")],
    take: Annotated[int | None, typer.Option(help="Id of a recorded take.")] = None,
    policy: Annotated[str | None, typer.Option(help="Or a policy, or another pilot.")] = None,
    seed: Annotated[int, typer.Option(help="Of the world the policy acts in.", min=0)] = 0,
    scene: Annotated[str | None, typer.Option(help="The policy's by default.")] = None,
    density: DensityOption = None,
    option: OptionsOption = None,
    camera: Annotated[str | None, typer.Option(help="From where it is seen.")] = None,
    width: Annotated[int, typer.Option(help="Points a video is wide.")] = 1280,
    height: Annotated[int, typer.Option(help="Points it is high.")] = 720,
    workspace: WorkspaceOption = HERE,
    store: StoreOption = None,
    json_output: JsonFlag = False,
) -> None:
    """Make a take, or what a policy does in one world, into a file to hand on."""
    from evastudio.demonstrations.store import Store
    from evastudio.live.films import check
    from evastudio.live.footage import policy_footage, take_footage
    from evastudio.studio.filming import film as make

    form, size, place = out.suffix[1:].lower(), (width, height), Workspace(workspace, store)
    with bar(json_output) as progress:
        if take is not None and policy is None:
            with Store(place.ready().store_url) as opened:
                footage = take_footage(place, opened, take, camera)
        elif policy is not None and take is None:
            check(form, size)  # before it acts
            options = options_of(density, option)
            footage = policy_footage(place, policy, seed, options, camera, scene)
        else:
            raise InvalidInputError("Give either --take or --policy: one of them is filmed.")
        result = make(place, footage, form, size, out, progress)
    show(result, json_output)
