"""Docs cannot rot: what exists is documented, and what is shown runs."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path
from typing import TYPE_CHECKING

import httpx
import pytest
import typer.main

from evastudio.cli import app
from evastudio.workspace import shipped

if TYPE_CHECKING:
    from conftest import Studio

ROOT = shipped()
README = (ROOT / "README.md").read_text(encoding="utf-8")


def names(requirements: list[str]) -> set[str]:
    return {re.split(r"[<>=\[ ]", requirement)[0] for requirement in requirements}


def test_every_dependency_has_its_line_of_reason() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    text = (ROOT / "docs" / "dependencies.md").read_text()
    assert set(re.findall(r"^\| ([a-z-]+) \| \S", text, re.MULTILINE)) - {"package"} == names(
        project["dependencies"]
    )
    for name in names(
        [one for extra in project["optional-dependencies"].values() for one in extra]
    ):
        assert name in text, name


def test_every_command_has_a_sentence_of_help() -> None:
    group = typer.main.get_command(app)
    commands = group.commands  # type: ignore[attr-defined]
    assert {
        "studio",
        "scenes",
        "check",
        "record",
        "import",
        "sessions",
        "clean",
        "diagnose",
        "tune",
        "fit",
        "switch",
        "evaluate",
    } <= set(commands)
    for name, command in commands.items():
        assert (command.help or "").endswith("."), name
        for parameter in command.params:
            assert parameter.name == "help" or parameter.help, f"{name} {parameter.name}"


def test_commands_in_the_readme_exist() -> None:
    group = typer.main.get_command(app)
    for shown in re.findall(r"^evastudio (\w+)", README, re.MULTILINE):
        assert shown in group.commands  # type: ignore[attr-defined]


def test_links_in_the_readme_lead_somewhere() -> None:
    for target in re.findall(r"\]\(([^)#]+)\)", README):
        assert (ROOT / target).exists(), target


def test_the_examples_of_the_api_run_as_they_stand(studio: Studio) -> None:
    text = (ROOT / "docs" / "api.md").read_text(encoding="utf-8")
    names: dict[str, object] = {"BASE": studio.base, "TOKEN": studio.token}
    for example in re.findall(r"```python\n(.*?)```", text, re.DOTALL):
        exec(example, names)
    client = names["api"]
    assert isinstance(client, httpx.Client)
    client.close()


def test_the_python_in_the_readme_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (example,) = re.findall(r"```python\n(.*?)```", README, re.DOTALL)
    shorter = example.replace("minutes=8", "minutes=1").replace("worlds=200", "worlds=8")
    assert len(shorter) == len(example) - 2
    monkeypatch.chdir(tmp_path)
    names: dict[str, object] = {}
    exec(shorter, names)
    assert (tmp_path / "my-folder" / "policies" / f"{names['policy']}.safetensors").is_file()
