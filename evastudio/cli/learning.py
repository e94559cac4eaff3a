"""Commands that make policies."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from evastudio.cli.app import app
from evastudio.cli.options import (
    HERE,
    ClusterOption,
    DelayOption,
    DensityOption,
    JobsOption,
    JsonFlag,
    OptionsOption,
    PolicyFileOption,
    StoreOption,
    WorkspaceOption,
    delay_of,
    number,
    options_of,
    settings_of,
)
from evastudio.cli.showing import bar, show, show_reported
from evastudio.workspace import Workspace


@app.command()
def clean(
    session: Annotated[str, typer.Argument(help="Id or name of a session.")],
    perception: Annotated[str | None, typer.Option(help="Name of a perception.")] = None,
    neighbors: Annotated[int | None, typer.Option(help="Neighbours compared.", min=1)] = None,
    threshold: Annotated[
        str | None, typer.Option(help="Share of the action's range, or 'auto'.")
    ] = None,
    delay: DelayOption = "auto",
    workspace: WorkspaceOption = HERE,
    store: StoreOption = None,
    json_output: JsonFlag = False,
) -> None:
    """Mark contradicting pairs of a session, so that fitting leaves them out."""
    from evastudio.live import cleaning

    chosen: dict[str, Any] = {}
    if neighbors is not None:
        chosen["n_neighbors"] = neighbors
    if threshold is not None:
        chosen["threshold"] = threshold if threshold == "auto" else number("threshold", threshold)
    with bar(json_output) as progress:
        result = cleaning.clean(
            Workspace(workspace, store),
            session,
            perception=perception,
            delay=delay_of(delay),
            progress=progress,
            **chosen,
        )
    show(result, json_output)


@app.command()
def tune(
    session: Annotated[str, typer.Argument(help="Id or name of a session.")],
    learner: Annotated[
        str, typer.Option(help="Tune one learner; auto compares all that suit.")
    ] = "auto",
    perception: Annotated[str | None, typer.Option(help="Name of a perception.")] = None,
    cluster: ClusterOption = None,
    workspace: WorkspaceOption = HERE,
    store: StoreOption = None,
    json_output: JsonFlag = False,
) -> None:
    """Try learners and settings on takes held out whole, and report what each gave.

    `fit --learner auto` does the same and fits what was chosen.
    """
    from evastudio.live.tuning import tune

    with bar(json_output) as progress:
        result = tune(
            Workspace(workspace, store),
            session,
            learner=learner,
            perception=perception,
            cluster=cluster,
            progress=progress,
        )
    if json_output:
        show(result, True)
        return
    print("\n".join(result["sentences"]), end="\n\n")
    rows = [{"learner": name, "error": result[name]} for name in ("constant", "linear")]
    rows += sorted(result["trials"], key=lambda row: row["error"])
    blank = {"settings": None, "threshold": None, "typical": None}
    columns = ("learner", "settings", "threshold", "error", "typical")
    show([{**blank, **row} for row in rows], False, columns)
    takes = [{"take": take, **errors} for take, errors in result["by_take"].items()]
    show(takes, False, ("take", "chosen", "constant", "linear"))


@app.command()
def diagnose(
    session: Annotated[str, typer.Argument(help="Id or name of a session.")],
    perception: Annotated[str | None, typer.Option(help="Name of a perception.")] = None,
    delay: DelayOption = "auto",
    workspace: WorkspaceOption = HERE,
    store: StoreOption = None,
    json_output: JsonFlag = False,
) -> None:
    """Say how late you answered, and what would keep a policy from learning a session."""
    from evastudio.live.diagnosing import diagnose

    with bar(json_output) as progress:
        result = diagnose(
            Workspace(workspace, store),
            session,
            perception=perception,
            delay=delay_of(delay),
            progress=progress,
        )
    if json_output:
        show(result, True)
    else:
        print("\n".join(result["sentences"]))


@app.command()
def fit(
    session: Annotated[str, typer.Argument(help="Id or name of a session.")],
    learner: Annotated[
        str | None,
        typer.Option(
            help="svr (smooth, the default), knn (exact), local-linear, sampled (as varied as "
            "shown), mlp (a neural network, to compare with); for symbols voting, sampled-voting, "
            "quantized-svr or quantized-knn; auto (chosen for you)."
        ),
    ] = None,
    perception: Annotated[str | None, typer.Option(help="Name of a perception.")] = None,
    setting: Annotated[
        list[str] | None, typer.Option("--set", help="A setting of the learner, as name=value.")
    ] = None,
    delay: DelayOption = "auto",
    out: PolicyFileOption = None,
    name: Annotated[str | None, typer.Option(help="Name in the workspace's policies.")] = None,
    workspace: WorkspaceOption = HERE,
    store: StoreOption = None,
    json_output: JsonFlag = False,
) -> None:
    """Fit a policy to the kept and cleaned pairs of a session."""
    from evastudio.live import headless

    with bar(json_output) as progress:
        result = headless.fit(
            Workspace(workspace, store),
            session,
            learner=learner,
            perception=perception,
            settings=settings_of(setting),
            delay=delay_of(delay),
            out=out,
            name=name,
            progress=progress,
        )
    show_reported(result, json_output)


@app.command()
def switch(
    name: Annotated[str, typer.Argument(help="Name of the switch.")],
    entries: Annotated[
        list[str],
        typer.Argument(
            help="Policies, the first choice first: 'POLICY when CONDITION' or 'POLICY once "
            "CONDITION', and last the one that acts otherwise. Conditions: event:impact, "
            "after:30s, region:x0,y0,x1,y1, boulder<5, learned:SESSION; joined by ' and '."
        ),
    ],
    perception: Annotated[
        str | None, typer.Option(help="What a learned condition may look at beside the signs.")
    ] = None,
    out: Annotated[Path | None, typer.Option(help="File to write, .switch.json.")] = None,
    workspace: WorkspaceOption = HERE,
    store: StoreOption = None,
    json_output: JsonFlag = False,
) -> None:
    """Let policies take turns: evastudio switch both "fleeing when event:impact" walking."""
    from evastudio.live import switching

    with bar(json_output) as progress:
        result = switching.switch(
            Workspace(workspace, store),
            name,
            [switching.parse_entry(entry) for entry in entries],
            perception=perception,
            out=out,
            progress=progress,
        )
    show_reported(result, json_output)


@app.command()
def search(
    scene: Annotated[str, typer.Argument(help="Name of a scene.")],
    optimiser: Annotated[str, typer.Option(help="cma-es or hill-climbing.")] = "cma-es",
    hidden: Annotated[int, typer.Option(help="Hidden units of the network.", min=1)] = 8,
    scenarios: Annotated[int, typer.Option(help="Fixed worlds to try in.", min=1)] = 24,
    horizon_s: Annotated[float, typer.Option(help="Seconds flown in each.", min=0.1)] = 24.0,
    population: Annotated[int, typer.Option(help="Networks tried in a round.", min=1)] = 32,
    rounds: Annotated[int, typer.Option(help="How many rounds.", min=1)] = 30,
    spread: Annotated[float, typer.Option(help="Of the weights tried first.", min=0.0)] = 0.15,
    loss: Annotated[float, typer.Option(help="What it costs to fail.", min=0.0)] = 0.5,
    calm: Annotated[float, typer.Option(help="What changes of action cost.", min=0.0)] = 0.5,
    seed: Annotated[int, typer.Option(help="Decides the worlds and the search.", min=0)] = 0,
    perception: Annotated[str | None, typer.Option(help="Name of a perception.")] = None,
    density: DensityOption = None,
    option: OptionsOption = None,
    out: PolicyFileOption = None,
    name: Annotated[str | None, typer.Option(help="Name in the workspace's policies.")] = None,
    jobs: JobsOption = 1,
    cluster: ClusterOption = None,
    workspace: WorkspaceOption = HERE,
    json_output: JsonFlag = False,
) -> None:
    """Search for a policy with no demonstration (PEGASUS), to compare with."""
    from evastudio.live.searching import search as find
    from evastudio.pilots.pegasus import Pegasus

    settings = Pegasus(
        optimiser=optimiser,
        hidden=hidden,
        scenarios=scenarios,
        horizon_s=horizon_s,
        population=population,
        rounds=rounds,
        spread=spread,
        loss=loss,
        calm=calm,
        seed=seed,
    )
    with bar(json_output) as progress:
        result = find(
            Workspace(workspace),
            scene,
            settings,
            perception=perception,
            options=options_of(density, option),
            out=out,
            name=name,
            jobs=jobs,
            cluster=cluster,
            progress=progress,
        )
    show(result, json_output)
