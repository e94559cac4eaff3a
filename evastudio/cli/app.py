"""The application that commands register with."""

from __future__ import annotations

import typer

app = typer.Typer(
    name="evastudio",
    help="Drive a character for a few minutes; it goes on alone in the style you showed.",
    pretty_exceptions_enable=False,
    add_completion=False,
    no_args_is_help=False,
)
