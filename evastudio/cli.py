"""The command line: the functions of `evastudio`, one command each."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn
from rich.table import Table

from evastudio.errors import InvalidInputError, StudioError
from evastudio.settings import DEFAULT_PORT, Settings
from evastudio.workspace import Workspace

app = typer.Typer(
    name="evastudio",
    help="Drive a character for a few minutes; it goes on alone in the style you showed.",
    pretty_exceptions_enable=False,
    add_completion=False,
    no_args_is_help=False,
)

JsonFlag = Annotated[bool, typer.Option("--json", help="Print JSON instead of text.")]
WorkspaceOption = Annotated[
    Path, typer.Option("--workspace", "-w", help="Folder with your scenes, policies, sessions.")
]
StoreOption = Annotated[
    str | None, typer.Option("--store", help="URL of the session store; studio.db by default.")
]
DensityOption = Annotated[
    float | None, typer.Option("--density", "-D", help="The scene's option 'density'.")
]
OptionsOption = Annotated[
    list[str] | None, typer.Option("--option", "-o", help="Another of its options, as name=value.")
]
DelayOption = Annotated[
    str, typer.Option("--delay", help="Reaction delay to take out: auto, off, or seconds.")
]
ClusterOption = Annotated[
    str | None, typer.Option(help="Run on the Dask cluster at this address, tcp://HOST:PORT.")
]
JobsOption = Annotated[int, typer.Option(help="Processes at once.", min=1)]
HERE = Path()


@app.callback(invoke_without_command=True)
def default(context: typer.Context) -> None:
    """Open the studio."""
    if context.invoked_subcommand is None:
        studio()


@app.command()
def studio(
    workspace: WorkspaceOption = HERE,
    store: StoreOption = None,
    host: Annotated[str, typer.Option(help="Address to listen at.")] = "127.0.0.1",
    port: Annotated[int, typer.Option(help="Port; 0 takes any free one.")] = DEFAULT_PORT,
    token: Annotated[str | None, typer.Option(help="Access token; a new one by default.")] = None,
    browser: Annotated[bool, typer.Option(help="Open the page in a browser.")] = True,
    json_output: JsonFlag = False,
) -> None:
    """Open the studio: serve the page and print its address."""
    from evastudio.server import serve  # the server's libraries are slow to load

    given: dict[str, Any] = {} if token is None else {"token": token}
    settings = Settings(Workspace(workspace, store), host, port, browser=browser, **given)

    def announce(url: str) -> None:
        text = json.dumps({"url": url}) if json_output else f"EVA Studio is open at\n\n    {url}\n"
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
    _print(rows, json_output, ("name", "title", "version", "options", "perceptions"))


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
        _print(result, True)
        return
    if result["problem"]:
        print(result["problem"], end="\n\n")
    _print(result["activities"], False, ("name", "file", "clip", "problem"))
    if result["files"]:
        print()
    _print(result["files"], False, ("name", "clips", "problem"))


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
    _print(rows, json_output, ("ok", "rule", "problem"))
    if any(found.problem for found in findings):
        raise typer.Exit(1)


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

    with _bar(json_output) as progress:
        result = headless.record(
            Workspace(workspace, store),
            scene,
            pilot,
            minutes,
            seed,
            options=_options(density, option),
            session=session,
            mark=mark,
            progress=progress,
        )
    _print(result, json_output)


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

    with _bar(json_output) as progress:
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
    _print(result, json_output)


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
    _print(
        rows, json_output, ("id", "name", "scene", "demonstrator", "takes_kept", "pairs", "seconds")
    )


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
    from evastudio.live import headless

    chosen: dict[str, Any] = {}
    if neighbors is not None:
        chosen["n_neighbors"] = neighbors
    if threshold is not None:
        chosen["threshold"] = threshold if threshold == "auto" else _number("threshold", threshold)
    with _bar(json_output) as progress:
        result = headless.clean(
            Workspace(workspace, store),
            session,
            perception=perception,
            delay=_delay(delay),
            progress=progress,
            **chosen,
        )
    _print(result, json_output)


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

    with _bar(json_output) as progress:
        result = tune(
            Workspace(workspace, store),
            session,
            learner=learner,
            perception=perception,
            cluster=cluster,
            progress=progress,
        )
    if json_output:
        _print(result, True)
        return
    print("\n".join(result["sentences"]), end="\n\n")
    rows = [{"learner": name, "error": result[name]} for name in ("constant", "linear")]
    rows += sorted(result["trials"], key=lambda row: row["error"])
    blank = {"settings": None, "threshold": None, "typical": None}
    columns = ("learner", "settings", "threshold", "error", "typical")
    _print([{**blank, **row} for row in rows], False, columns)
    takes = [{"take": take, **errors} for take, errors in result["by_take"].items()]
    _print(takes, False, ("take", "chosen", "constant", "linear"))


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

    with _bar(json_output) as progress:
        result = diagnose(
            Workspace(workspace, store),
            session,
            perception=perception,
            delay=_delay(delay),
            progress=progress,
        )
    if json_output:
        _print(result, True)
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
    out: Annotated[Path | None, typer.Option(help="File to write, .safetensors.")] = None,
    name: Annotated[str | None, typer.Option(help="Name in the workspace's policies.")] = None,
    workspace: WorkspaceOption = HERE,
    store: StoreOption = None,
    json_output: JsonFlag = False,
) -> None:
    """Fit a policy to the kept and cleaned pairs of a session."""
    from evastudio.live import headless

    if out is not None and out.suffix != ".safetensors":
        raise InvalidInputError(f"The file is {str(out)!r}; a policy file ends in .safetensors.")
    with _bar(json_output) as progress:
        result = headless.fit(
            Workspace(workspace, store),
            session,
            learner=learner,
            perception=perception,
            settings=_settings(setting),
            delay=_delay(delay),
            out=out,
            name=name,
            progress=progress,
        )
    report = [] if json_output else result.pop("report")
    _print(result, json_output)
    if report:
        print("\n" + "\n".join(report))


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

    with _bar(json_output) as progress:
        result = switching.switch(
            Workspace(workspace, store),
            name,
            [switching.parse_entry(entry) for entry in entries],
            perception=perception,
            out=out,
            progress=progress,
        )
    report = [] if json_output else result.pop("report")
    _print(result, json_output)
    if report:
        print("\n" + "\n".join(report))


@app.command()
def search(
    scene: Annotated[str, typer.Argument(help="Name of a scene.")],
    optimiser: Annotated[str, typer.Option(help="cma-es or hill-climbing.")] = "cma-es",
    hidden: Annotated[int, typer.Option(help="Hidden units of the network.", min=1)] = 8,
    scenarios: Annotated[int, typer.Option(help="Fixed worlds to try in.", min=1)] = 24,
    horizon_s: Annotated[float, typer.Option(help="Seconds flown in each.", min=0.1)] = 24.0,
    population: Annotated[int, typer.Option(help="Networks tried in a round.", min=1)] = 32,
    rounds: Annotated[int, typer.Option(help="How many rounds.", min=1)] = 60,
    spread: Annotated[float, typer.Option(help="Of the weights tried first.", min=0.0)] = 0.5,
    calm: Annotated[float, typer.Option(help="What it costs to change the action.")] = 0.5,
    seed: Annotated[int, typer.Option(help="Decides the worlds and the search.", min=0)] = 0,
    perception: Annotated[str | None, typer.Option(help="Name of a perception.")] = None,
    density: DensityOption = None,
    option: OptionsOption = None,
    out: Annotated[Path | None, typer.Option(help="File to write, .safetensors.")] = None,
    name: Annotated[str | None, typer.Option(help="Name in the workspace's policies.")] = None,
    workspace: WorkspaceOption = HERE,
    json_output: JsonFlag = False,
) -> None:
    """Search for a policy with no demonstration (PEGASUS), to compare with."""
    from evastudio.live.searching import search as find
    from evastudio.pilots.pegasus import Pegasus

    if out is not None and out.suffix != ".safetensors":
        raise InvalidInputError(f"The file is {str(out)!r}; a policy file ends in .safetensors.")
    settings = Pegasus(
        optimiser=optimiser,
        hidden=hidden,
        scenarios=scenarios,
        horizon_s=horizon_s,
        population=population,
        rounds=rounds,
        spread=spread,
        calm=calm,
        seed=seed,
    )
    with _bar(json_output) as progress:
        result = find(
            Workspace(workspace),
            scene,
            settings,
            perception=perception,
            options=_options(density, option),
            out=out,
            name=name,
            progress=progress,
        )
    _print(result, json_output)


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
    jobs: JobsOption = 1,
    cluster: ClusterOption = None,
    workspace: WorkspaceOption = HERE,
    store: StoreOption = None,
    json_output: JsonFlag = False,
) -> None:
    """Fly policies through the same new worlds, and compare them world by world."""
    from evastudio.live import evaluating

    with _bar(json_output) as progress:
        result = evaluating.evaluate(
            Workspace(workspace, store),
            policies,
            scene=scene,
            worlds=worlds,
            seed=seed,
            options=_options(density, option),
            like=like,
            jobs=jobs,
            cluster=cluster,
            progress=progress,
        )
    if json_output:
        _print(result, True)
    else:
        _print_figures(result)
        for pair in result["differences"]:
            ours, theirs = pair.pop("pilots")
            print(f"\n{ours} less {theirs}, world by world")
            _print(
                [
                    {"": figure, **found, "95 %": found["interval"]}
                    for figure, found in pair.items()
                ],
                False,
                ("", "difference", "95 %", "p", "effect", "worlds"),
            )


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
        with _bar(json_output) as progress:
            _print(
                evaluating.repeat_evaluation(place, again, jobs=jobs, progress=progress),
                json_output,
            )
        return
    found = evaluating.evaluations(place, scene)
    rows = [{**one, **one["asked"], "policies": list(one["asked"]["policies"])} for one in found]
    _print(
        found if json_output else rows,
        json_output,
        ("id", "scene", "policies", "worlds", "seed", "options"),
    )


def main() -> None:
    """Run the command line: what is refused is one sentence and exit code 2."""
    try:
        app()
    except StudioError as error:
        print(f"evastudio: {error}", file=sys.stderr)
        sys.exit(2)


def _print_figures(result: dict[str, Any]) -> None:
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
    _print(rows, False, ("", *policies))


def _options(density: float | None, pairs: list[str] | None) -> dict[str, float]:
    values = {} if density is None else {"density": density}
    for name, value in _split(pairs, "--option"):
        values[name] = _number(name, value)
    return values


def _settings(pairs: list[str] | None) -> dict[str, Any]:
    settings: dict[str, Any] = {}
    for name, value in _split(pairs, "--set"):
        try:
            settings[name] = json.loads(value)
        except json.JSONDecodeError:
            settings[name] = value
    return settings


def _split(pairs: list[str] | None, flag: str) -> list[tuple[str, str]]:
    split = []
    for pair in pairs or []:
        name, found, value = pair.partition("=")
        if not found or not name:
            raise InvalidInputError(f"{flag} is {pair!r}; it must be name=value.")
        split.append((name, value))
    return split


def _number(name: str, text: str) -> float:
    try:
        return float(text)
    except ValueError:
        raise InvalidInputError(f"{name} is {text!r}; it must be a number.") from None


def _delay(text: str) -> Any:
    return text if text in ("auto", "off") else _number("delay", text)


class _bar:  # noqa: N801 - reads as a verb where it is used
    """A progress bar on standard error; silent with JSON or without a terminal."""

    def __init__(self, quiet: bool) -> None:
        console = Console(stderr=True)
        self._shown = not quiet and console.is_terminal
        self._bar = Progress(
            TextColumn("{task.description}"), BarColumn(), console=console, transient=True
        )

    def __enter__(self) -> Callable[[float, str], None]:
        if self._shown:
            self._bar.start()
        task = self._bar.add_task("", total=1.0)

        def progress(share: float, doing: str) -> None:
            self._bar.update(task, completed=share, description=doing)

        return progress

    def __exit__(self, *_: object) -> None:
        if self._shown:
            self._bar.stop()


def _print(result: Any, as_json: bool, columns: tuple[str, ...] = ()) -> None:
    if as_json:
        print(json.dumps(result, indent=2))
        return
    if isinstance(result, dict):
        result, columns = [{"": key, " ": value} for key, value in result.items()], ("", " ")
    table = Table(*columns, show_header=columns != ("", " "), box=None)
    for row in result:
        table.add_row(*(_text(row[column]) for column in columns))
    Console(soft_wrap=True, markup=False).print(table)


def _text(value: Any) -> str:
    if isinstance(value, float):
        return f"{value:.4g}"
    if isinstance(value, dict):
        return ", ".join(f"{key} {_text(part)}" for key, part in value.items())
    if isinstance(value, list | tuple):
        return ", ".join(_text(part) for part in value)
    return "" if value is None else str(value)
