"""The command line: the functions of `evastudio`, one command each."""

from __future__ import annotations

import sys

import typer

# In the order in which help lists them.
from evastudio.cli import workshop  # isort: split

from evastudio.cli import sessions  # isort: split

from evastudio.cli import learning  # isort: split

from evastudio.cli import evaluations  # isort: split

from evastudio.cli import films  # isort: split

from evastudio.cli import tokens  # isort: split

from evastudio.cli import backups  # isort: split

from evastudio.cli import doctoring  # isort: split

from evastudio.cli import paper  # isort: split

from evastudio.cli.app import app
from evastudio.errors import StudioError

__all__ = [
    "app",
    "backups",
    "doctoring",
    "evaluations",
    "films",
    "learning",
    "main",
    "paper",
    "sessions",
    "tokens",
    "workshop",
]


@app.callback(invoke_without_command=True)
def default(context: typer.Context) -> None:
    """Open the studio."""
    if context.invoked_subcommand is None:
        studio = typer.main.get_command(app).commands["studio"]  # type: ignore[attr-defined]
        with studio.make_context("studio", [], parent=context) as made:  # reads the environment
            studio.invoke(made)


def main() -> None:
    """Run the command line: what is refused is one sentence and exit code 2."""
    try:
        app()
    except StudioError as error:
        print(f"evastudio: {error}", file=sys.stderr)
        sys.exit(2)
