"""Commands of the workshop itself: the studio, the scenes and clips at hand."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated, Any

import typer

from evastudio.cli.app import app
from evastudio.cli.options import HERE, JsonFlag, StoreOption, WorkspaceOption
from evastudio.cli.showing import show
from evastudio.errors import InvalidInputError
from evastudio.logs import Form, Level, Logs
from evastudio.settings import DEFAULT_PORT, Settings
from evastudio.workspace import Workspace


@app.command()
def studio(
    workspace: WorkspaceOption = HERE,
    store: StoreOption = None,
    host: Annotated[str, typer.Option(help="Address to listen at.")] = "127.0.0.1",
    port: Annotated[int, typer.Option(help="Port; 0 takes any free one.")] = DEFAULT_PORT,
    token: Annotated[
        str | None,
        typer.Option(envvar="EVASTUDIO_TOKEN", help="Access token; a new one by default."),
    ] = None,
    public_url: Annotated[
        str | None,
        typer.Option(help="Address that a proxy in front shows, as https://studio.example."),
    ] = None,
    behind_proxy: Annotated[
        str | None, typer.Option(help="Address of that proxy, whose X-Forwarded-For is believed.")
    ] = None,
    browser: Annotated[bool, typer.Option(help="Open the page in a browser.")] = True,
    log_format: Annotated[Form, typer.Option(help="How events are written to stderr.")] = Form.TEXT,
    log_level: Annotated[
        Level, typer.Option(help="Events below it are not; requests are of level info.")
    ] = Level.WARNING,
    json_output: JsonFlag = False,
) -> None:
    """Open the studio: serve the page and print its address."""
    from evastudio.server import serve  # the server's libraries are slow to load

    given: dict[str, Any] = {"remember": True} if token is None else {"token": token}
    settings = Settings(
        Workspace(workspace, store),
        host,
        port,
        public_url=public_url,
        behind_proxy=behind_proxy,
        browser=browser,
        logs=Logs(log_format, log_level),
        **given,
    )

    def announce(url: str) -> None:
        exposed = settings.exposure
        if json_output:
            text = json.dumps({"url": url, **({"exposure": exposed} if exposed else {})})
        else:
            text = f"EVA Studio is open at\n\n    {url}\n"
            text += f"\n{exposed}\n" if exposed else ""
        print(text, flush=True)

    serve(settings, announce)


@app.command()
def scenes(workspace: WorkspaceOption = HERE, json_output: JsonFlag = False) -> None:
    """List the scenes at hand."""
    from evastudio.live import headless

    made = [kind() for kind in headless.scenes(Workspace(workspace))]
    rows = [
        {
            "name": scene.name,
            "title": scene.title,
            "version": scene.version,
            "dt_s": scene.dt_s,
            "options": dict(scene.values),
            "perceptions": list(scene.perceptions),
        }
        for scene in made
    ]
    show(rows, json_output, ("name", "title", "version", "options", "perceptions"))


@app.command()
def clips(
    activity: Annotated[
        str | None, typer.Argument(help="Choose for stand, walk, run, stagger, fallen, getting_up.")
    ] = None,
    file: Annotated[str | None, typer.Argument(help="File in the workspace's motion/.")] = None,
    clip: Annotated[
        str | None, typer.Argument(help="Clip in that file; not needed where it has but one.")
    ] = None,
    shipped: Annotated[
        bool, typer.Option("--shipped", help="Move as shipped again in that activity.")
    ] = False,
    workspace: WorkspaceOption = HERE,
    json_output: JsonFlag = False,
) -> None:
    """List the clips at hand, or choose one: evastudio clips walk hero.glb Walking_A."""
    from evastudio.live import clips as chosen

    place = Workspace(workspace)
    if activity is None:
        result = chosen.clips(place)
    elif shipped:
        result = chosen.forget_clip(place, activity)
    elif file is None:
        raise InvalidInputError(
            f"No file was given for {activity!r}; name a file in motion/, or say --shipped."
        )
    else:
        result = chosen.choose_clip(place, activity, file, clip)
    if json_output:
        show(result, True)
        return
    if result["problem"]:
        print(result["problem"], end="\n\n")
    show(result["activities"], False, ("name", "file", "clip", "problem"))
    if result["files"]:
        print()
    show(result["files"], False, ("name", "clips", "problem"))


@app.command()
def check(
    file: Annotated[Path, typer.Argument(help="A scene's Python file.")],
    workspace: WorkspaceOption = HERE,
    json_output: JsonFlag = False,
) -> None:
    """Test whether a scene file keeps the rules of scenes; exit code 1 if it does not.

    FILE may lie in the workspace's folder of scenes.
    """
    from evastudio.world.check import check_file

    own = workspace / "scenes" / file
    findings = check_file(own if own.is_file() and not file.is_file() else file)
    rows = [
        {"rule": found.rule, "ok": found.problem is None, "problem": found.problem}
        for found in findings
    ]
    show(rows, json_output, ("ok", "rule", "problem"))
    if any(found.problem for found in findings):
        raise typer.Exit(1)
