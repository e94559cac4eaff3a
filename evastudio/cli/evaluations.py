"""Commands that compare policies."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from evastudio.cli.app import app
from evastudio.cli.options import (
    HERE,
    ClusterOption,
    DensityOption,
    JobsOption,
    JsonFlag,
    OptionsOption,
    StoreOption,
    WorkspaceOption,
    options_of,
)
from evastudio.cli.showing import bar, show
from evastudio.workspace import Workspace


@app.command("compare", help="The same as evaluate, by another name.")
@app.command()
def evaluate(
    policies: Annotated[
        list[str],
        typer.Argument(
            help="Policies (name or file), scripted:NAME, straight, astar, or guarded:ANY."
        ),
    ],
    worlds: Annotated[int, typer.Option(help="How many new worlds.", min=1)] = 100,
    seed: Annotated[int, typer.Option(help="Decides the worlds.", min=0)] = 0,
    scene: Annotated[str | None, typer.Option(help="The first policy's by default.")] = None,
    density: DensityOption = None,
    option: OptionsOption = None,
    like: Annotated[
        str | None, typer.Option(help="The one of them that the others should move like.")
    ] = None,
    like_session: Annotated[
        str | None, typer.Option(help="The session whose takes they should move like.")
    ] = None,
    jobs: JobsOption = 1,
    cluster: ClusterOption = None,
    pictures: Annotated[
        Path | None, typer.Option(help="Folder to draw outcomes, paths and actions into.")
    ] = None,
    workspace: WorkspaceOption = HERE,
    store: StoreOption = None,
    json_output: JsonFlag = False,
) -> None:
    """Fly policies through the same new worlds, and compare them world by world."""
    from evastudio.live import evaluating

    with bar(json_output) as progress:
        result = evaluating.evaluate(
            Workspace(workspace, store),
            policies,
            scene=scene,
            worlds=worlds,
            seed=seed,
            options=options_of(density, option),
            like=like,
            like_session=like_session,
            jobs=jobs,
            cluster=cluster,
            pictures=pictures,
            progress=progress,
        )
    if json_output:
        show(result, True)
    else:
        _show_figures(result)
        for says, pair in zip(result["says"], result["differences"], strict=True):
            ours, theirs = pair.pop("pilots")
            print(f"\n{ours} less {theirs}, world by world")
            show(
                [
                    {"": figure, **found, "95 %": found["interval"]}
                    for figure, found in pair.items()
                ],
                False,
                ("", "difference", "95 %", "p", "p_corrected", "effect", "worlds"),
            )
            print(says)


@app.command()
def evaluations(
    again: Annotated[
        int | None, typer.Option(help="Make the evaluation of this id again, and compare.")
    ] = None,
    scene: Annotated[str | None, typer.Option(help="Only those of this scene.")] = None,
    jobs: JobsOption = 1,
    workspace: WorkspaceOption = HERE,
    store: StoreOption = None,
    json_output: JsonFlag = False,
) -> None:
    """List the evaluations kept, or make one again to see that nothing differs."""
    from evastudio.live import evaluating

    place = Workspace(workspace, store)
    if again is not None:
        with bar(json_output) as progress:
            show(
                evaluating.repeat_evaluation(place, again, jobs=jobs, progress=progress),
                json_output,
            )
        return
    found = evaluating.evaluations(place, scene)
    rows = [{**one, **one["asked"], "policies": list(one["asked"]["policies"])} for one in found]
    show(
        found if json_output else rows,
        json_output,
        ("id", "scene", "policies", "worlds", "seed", "options"),
    )


def _show_figures(result: dict[str, Any]) -> None:
    """A column for each policy; means, with the interval of the success rate."""
    policies = result["policies"]
    figures = list(dict.fromkeys(name for one in policies.values() for name in one["figures"]))
    rows: list[dict[str, Any]] = []
    for key in ("success_rate", "interval", *figures, "unlike", "decision_us"):
        row: dict[str, Any] = {"": "95 %" if key == "interval" else key}
        for name, one in policies.items():
            found = one["figures"].get(key) if key in figures else one[key]
            row[name] = found["mean"] if isinstance(found, dict) else found
        rows.append(row)
    show(rows, False, ("", *policies))
