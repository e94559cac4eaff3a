"""What CI installs is written down to the version."""

from __future__ import annotations

import re
import tomllib

from evastudio.workspace import shipped

ROOT = shipped()
LOCKED = (ROOT / "constraints.txt").read_text(encoding="utf-8").splitlines()[1:]


def plain(name: str) -> str:
    return re.sub(r"[-_.]+", "-", name).lower()


def test_every_locked_package_has_one_version() -> None:
    assert len(LOCKED) > 50
    for line in LOCKED:
        assert re.fullmatch(r"[\w.-]+==[\w.+!]+", line), line
    assert len({plain(line.partition("==")[0]) for line in LOCKED}) == len(LOCKED)


def test_every_package_that_ci_asks_for_is_locked() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    extras = project["optional-dependencies"]
    asked = [*project["dependencies"], *extras["dev"], *extras["bench"], *extras["rl"]]
    locked = {plain(line.partition("==")[0]) for line in LOCKED}
    missing = {plain(re.split(r"[<>=\[ ;]", one)[0]) for one in asked} - locked - {"torch"}
    assert not missing, f"{sorted(missing)} are not in constraints.txt; run `make lock`."
    # One build on Linux and another elsewhere: the project itself names it to the version.
    assert any(re.match(r"torch==[\w.+]+; sys_platform == 'linux'", one) for one in extras["rl"])
