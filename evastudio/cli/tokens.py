"""Commands that say whom a studio lets in."""

from __future__ import annotations

import time
from typing import Annotated

import typer

from evastudio.cli.app import app
from evastudio.cli.options import HERE, JsonFlag, StoreOption, WorkspaceOption
from evastudio.cli.showing import show
from evastudio.live.tokens import Role, Tokens
from evastudio.workspace import Workspace

tokens = typer.Typer(help="Say whom the studio lets in: list, add or revoke tokens.")
app.add_typer(tokens, name="tokens", invoke_without_command=True)


@tokens.callback()
def listed(
    context: typer.Context,
    workspace: WorkspaceOption = HERE,
    store: StoreOption = None,
    json_output: JsonFlag = False,
) -> None:
    """List the tokens of a studio, or add and revoke them."""
    if context.invoked_subcommand is not None:
        return
    from evastudio.demonstrations.store import Store

    with Store(Workspace(workspace, store).ready().store_url) as opened:
        rows = [
            {
                "name": token.name,
                "role": token.role.value,
                "since": _day(token.created_at),
                "revoked": None if token.revoked_at is None else _day(token.revoked_at),
            }
            for token in Tokens(opened).all()
        ]
    show(rows, json_output, ("name", "role", "since", "revoked"))


@tokens.command()
def add(
    name: Annotated[str, typer.Argument(help="Whom it is for.")],
    role: Annotated[
        Role, typer.Option(help="An author may do everything; a viewer watches and reads.")
    ] = Role.VIEWER,
    workspace: WorkspaceOption = HERE,
    store: StoreOption = None,
    json_output: JsonFlag = False,
) -> None:
    """Make a token for somebody, and print it this once."""
    from evastudio.demonstrations.store import Store

    with Store(Workspace(workspace, store).ready().store_url) as opened:
        secret = Tokens(opened).add(name, role, time.time())
    if json_output:
        show({"name": name, "role": role.value, "token": secret}, True)
        return
    print(
        f"The token of {name!r}, {role.value}; it is shown this once:\n\n    {secret}\n\n"
        f"It opens the studio at its address with /?token={secret}"
    )


@tokens.command()
def revoke(
    name: Annotated[str, typer.Argument(help="Whose token.")],
    workspace: WorkspaceOption = HERE,
    store: StoreOption = None,
) -> None:
    """Let somebody in no longer; whoever is connected with that token is cut off."""
    from evastudio.demonstrations.store import Store

    with Store(Workspace(workspace, store).ready().store_url) as opened:
        Tokens(opened).revoke(name, time.time())
    print(f"The token of {name!r} is revoked.")


def _day(seconds: float) -> str:
    return time.strftime("%Y-%m-%d %H:%M", time.localtime(seconds))
