"""Benchmarks are run by hand, some with extras that tests lack: what they import exists."""

from __future__ import annotations

import ast
from pathlib import Path

ROOT = Path(__file__).parents[2]
FILES = sorted((ROOT / "benchmarks").rglob("*.py"))


def made_in(path: Path) -> set[str]:
    """Every name that a module has."""
    names: set[str] = set()
    for node in ast.parse(path.read_text()).body:
        match node:
            case (
                ast.FunctionDef(name=name)
                | ast.AsyncFunctionDef(name=name)
                | ast.ClassDef(name=name)
            ):
                names.add(name)
            case ast.Assign(targets=targets):
                parts = [part for target in targets for part in ast.walk(target)]
                names |= {part.id for part in parts if isinstance(part, ast.Name)}
            case ast.AnnAssign(target=ast.Name(id=name)):
                names.add(name)
            case ast.Import(names=aliases) | ast.ImportFrom(names=aliases):
                names |= {alias.asname or alias.name for alias in aliases}
    return names


def test_what_benchmarks_take_from_each_other_exists() -> None:
    missing = []
    siblings = {path.stem for path in FILES}
    for path in FILES:
        for node in ast.walk(ast.parse(path.read_text())):
            if not isinstance(node, ast.ImportFrom) or node.module is None:
                continue
            if node.module in siblings:
                missing.append(f"{path.name}: {node.module} is benchmarks.{node.module}")
            if node.module.startswith("benchmarks."):
                source = ROOT / (node.module.replace(".", "/") + ".py")
                known = made_in(source) if source.exists() else set()
                missing += [
                    f"{path.name}: {node.module}.{alias.name}"
                    for alias in node.names
                    if alias.name not in known
                ]
    assert missing == []
