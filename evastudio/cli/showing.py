"""How results and progress are shown in a terminal."""

from __future__ import annotations

import json
from collections.abc import Callable
from typing import Any

from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn
from rich.table import Table


class bar:  # noqa: N801 - reads as a verb where it is used
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


def show(result: Any, as_json: bool, columns: tuple[str, ...] = ()) -> None:
    if as_json:
        print(json.dumps(result, indent=2))
        return
    if isinstance(result, dict):
        result, columns = [{"": key, " ": value} for key, value in result.items()], ("", " ")
    table = Table(*columns, show_header=columns != ("", " "), box=None)
    for row in result:
        table.add_row(*(_text(row[column]) for column in columns))
    Console(soft_wrap=True, markup=False).print(table)


def show_reported(result: dict[str, Any], as_json: bool) -> None:
    """`show`, and below it the sentences of its report."""
    show({key: value for key, value in result.items() if as_json or key != "report"}, as_json)
    if result["report"] and not as_json:
        print("\n" + "\n".join(result["report"]))


def _text(value: Any) -> str:
    if isinstance(value, float):
        return f"{value:.4g}"
    if isinstance(value, dict):
        return ", ".join(f"{key} {_text(part)}" for key, part in value.items())
    if isinstance(value, list | tuple):
        return ", ".join(_text(part) for part in value)
    return "" if value is None else str(value)
