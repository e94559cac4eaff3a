"""What the document on the client shows, runs."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Any

from evastudio.workspace import shipped

if TYPE_CHECKING:
    from conftest import Studio


def test_the_lines_that_are_shown_run(studio: Studio) -> None:
    text = (shipped() / "docs" / "client.md").read_text(encoding="utf-8")
    (shown,) = re.findall(r"```python\n(.*?)```", text, re.DOTALL)
    names: dict[str, Any] = {"URL": studio.url}
    exec(compile(shown, "client.md", "exec"), names)
    assert names["actions"].shape == (1, 2)
    assert names["fitted"].state == "done"
