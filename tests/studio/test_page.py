"""The pages' files fit together, and keep the content security policy."""

from __future__ import annotations

import re
from html.parser import HTMLParser
from pathlib import Path

import pytest

WEB = Path(__file__).parents[2] / "web"
MODULES = sorted((WEB / "js").glob("*.js"))
SHEETS = sorted((WEB / "css").glob("*.css"))
PAGES = sorted(WEB.glob("*.html"))
OWN = {"/", "/compare", "/vote", "/api/v1/ballots/table-3"}
"""Addresses of pages, which links lead to."""


class Reader(HTMLParser):
    """Collects what the tests ask of the page."""

    def __init__(self) -> None:
        super().__init__()
        self.ids: list[str] = []
        self.links: list[str] = []
        self.inline: list[str] = []
        self.buttons: list[dict[str, str | None]] = []
        self._script = False

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        given = dict(attrs)
        self.ids += [value for value in [given.get("id")] if value]
        for name in ("src", "href"):
            self.links += [value for value in [given.get(name)] if value]
        self.inline += [name for name in given if name == "style" or name.startswith("on")]
        if tag == "style":
            self.inline.append(tag)
        if tag == "button":
            self.buttons.append(given)
        self._script = tag == "script"

    def handle_data(self, data: str) -> None:
        if self._script and data.strip():
            self.inline.append("script")

    def handle_endtag(self, tag: str) -> None:
        self._script = False


@pytest.fixture(scope="module", params=PAGES, ids=lambda path: path.stem)
def page(request: pytest.FixtureRequest) -> Reader:
    reader = Reader()
    reader.feed(request.param.read_text(encoding="utf-8"))
    return reader


def used(page: Reader) -> set[Path]:
    """The modules that a page loads, and those that these import."""
    left = [WEB / link.removeprefix("/web/") for link in page.links if link.endswith(".js")]
    found: set[Path] = set()
    while left:
        module = left.pop()
        if module not in found:
            found.add(module)
            imported = re.findall(r'from "\./([\w.]+)";', module.read_text(encoding="utf-8"))
            left += [module.parent / name for name in imported]
    return found


def test_the_page_keeps_a_strict_policy(page: Reader) -> None:
    assert page.inline == []
    for module in MODULES:
        source = module.read_text(encoding="utf-8")
        for forbidden in ("innerHTML", "outerHTML", "insertAdjacentHTML", "eval(", ".style."):
            assert forbidden not in source, f"{module.name} uses {forbidden}"


def test_a_step_comes_before_what_takes_it_back() -> None:
    reader = Reader()
    reader.feed((WEB / "index.html").read_text(encoding="utf-8"))
    order = [given.get("id") for given in reader.buttons]
    for step, back in (("demonstrate", "undo"), ("clean", "unclean")):
        assert order.index(back) == order.index(step) + 1


def test_nothing_comes_from_outside(page: Reader) -> None:
    for link in page.links:
        if link in OWN:
            continue
        assert link.startswith("/web/"), link
        assert (WEB / link.removeprefix("/web/")).is_file(), link
    for file in (*MODULES, *SHEETS):
        text = file.read_text(encoding="utf-8")
        assert "//" not in re.sub(r"//[^\n]*|\$\{scheme\}//", "", text) or file.suffix == ".js"
        assert not re.search(r"https?://", text), file.name


def test_ids_are_unique_and_those_that_scripts_rely_on_exist(page: Reader) -> None:
    assert len(page.ids) == len(set(page.ids))
    modules = used(page)
    assert modules
    wanted = set()
    for module in modules:
        wanted |= set(re.findall(r'byId\("([\w-]+)"', module.read_text(encoding="utf-8")))
    assert wanted <= set(page.ids)


def test_every_module_is_used_by_a_page() -> None:
    loaded: set[Path] = set()
    for path in PAGES:
        reader = Reader()
        reader.feed(path.read_text(encoding="utf-8"))
        loaded |= used(reader)
    assert {module.name for module in MODULES} - {"types.js"} == {one.name for one in loaded}


def test_every_import_names_something_that_is_exported() -> None:
    exported = {
        module.name: set(
            re.findall(
                r"^export (?:async )?(?:function|class|const) (\w+)",
                module.read_text(encoding="utf-8"),
                flags=re.MULTILINE,
            )
        )
        for module in MODULES
    }
    for module in MODULES:
        source = module.read_text(encoding="utf-8")
        for names, origin in re.findall(r'^import \{([^}]+)\} from "\./([\w.]+)";', source, re.M):
            for name in (part.strip() for part in names.split(",")):
                assert name in exported[origin], f"{module.name} imports {name} from {origin}"


def test_buttons_never_submit_by_accident(page: Reader) -> None:
    assert all(button.get("type") in {"button", "submit"} for button in page.buttons)
