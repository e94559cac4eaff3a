"""The house: imports point one way."""

from __future__ import annotations

import ast
from pathlib import Path

import evastudio

ORDER = ["world", "scenery", "motion", "demonstrations", "learning", "pilots", "evaluation", "live"]
FACES = ["studio", "api", "observing"]
CLIENT = "client"
"""Far from the studio: it knows no room, only errors."""
DOOR = "cli"
"""The command line may use everything."""
GROUND = {"errors", "logs", "workspace", "settings", "writing"}
"""Modules at the top level that know nothing of the rooms."""
SCREENS = {"viser", "fastapi", "starlette", "uvicorn", "webbrowser"}

ROOT = Path(evastudio.__file__).parent


def imported(path: Path) -> set[str]:
    """Dotted names that a file imports, anywhere in it."""
    names: set[str] = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            names.update(alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path}: imports are absolute"
            names.update(f"{node.module}.{alias.name}" for alias in node.names)
    return names


def allowed(room: str) -> set[str]:
    if room in ORDER:
        return GROUND | set(ORDER[: ORDER.index(room) + 1])
    if room == CLIENT:
        return {"errors", CLIENT}
    if room == DOOR:
        return GROUND | {*ORDER, *FACES, DOOR, "server"}
    return GROUND | set(ORDER) | {room}


def files() -> list[tuple[str, Path]]:
    rooms = [path for path in ROOT.iterdir() if path.is_dir() and (path / "__init__.py").is_file()]
    return [(room.name, file) for room in rooms for file in sorted(room.rglob("*.py"))]


def test_every_room_is_known() -> None:
    assert {room for room, _ in files()} <= {*ORDER, *FACES, CLIENT, DOOR}


def test_imports_point_one_way() -> None:
    wrong = [
        f"{file.relative_to(ROOT)} imports {name}"
        for room, file in files()
        for name in imported(file)
        if name.startswith("evastudio.") and name.split(".")[1] not in allowed(room)
    ]
    assert wrong == []


def test_what_runs_without_a_screen_knows_none() -> None:
    wrong = [
        f"{file.relative_to(ROOT)} imports {name}"
        for room, file in files()
        if room in ORDER
        for name in imported(file)
        if name.split(".")[0] in SCREENS
    ]
    assert wrong == []


def test_only_the_studio_knows_viser() -> None:
    knowing = {
        room for room, file in files() if any(n.split(".")[0] == "viser" for n in imported(file))
    }
    assert knowing <= {"studio"}


def test_the_ground_floor_imports_no_room() -> None:
    for name in GROUND:
        inner = {n for n in imported(ROOT / f"{name}.py") if n.startswith("evastudio.")}
        assert all(n.split(".")[1] in GROUND for n in inner), name
