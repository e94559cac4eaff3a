"""Options that commands share, and what is made of their texts."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated, Any

import typer

from evastudio.errors import InvalidInputError

JsonFlag = Annotated[bool, typer.Option("--json", help="Print JSON instead of text.")]
WorkspaceOption = Annotated[
    Path, typer.Option("--workspace", "-w", help="Folder with your scenes, policies, sessions.")
]
StoreOption = Annotated[
    str | None,
    typer.Option(
        "--store", envvar="EVASTUDIO_STORE", help="URL of the session store; studio.db by default."
    ),
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


def _policy_file(out: Path | None) -> Path | None:
    if out is not None and out.suffix != ".safetensors":
        raise InvalidInputError(f"The file is {str(out)!r}; a policy file ends in .safetensors.")
    return out


PolicyFileOption = Annotated[
    Path | None,
    typer.Option("--out", help="File to write, .safetensors.", callback=_policy_file),
]
JobsOption = Annotated[int, typer.Option(help="Processes at once.", min=1)]
HERE = Path()


def options_of(density: float | None, pairs: list[str] | None) -> dict[str, float]:
    values = {} if density is None else {"density": density}
    for name, value in _split(pairs, "--option"):
        values[name] = number(name, value)
    return values


def settings_of(pairs: list[str] | None) -> dict[str, Any]:
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


def number(name: str, text: str) -> float:
    try:
        return float(text)
    except ValueError:
        raise InvalidInputError(f"{name} is {text!r}; it must be a number.") from None


def delay_of(text: str) -> Any:
    return text if text in ("auto", "off") else number("delay", text)
