"""Sections that benchmarks write into documents, and where and when they were measured."""

from __future__ import annotations

import argparse
import os
import platform
import subprocess
from collections.abc import Callable
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path

from evastudio.evaluation.versions import processor

ROOT = Path(__file__).resolve().parent.parent


def write_section(path: Path, name: str, text: str) -> None:
    """Put `text` between the markers of `name` in the Markdown file, at its end if they are new.

    What stands outside the markers stays as it is, so several benchmarks can share one file.
    """
    start, end = f"<!-- {name} -->", f"<!-- end of {name} -->"
    section = f"{start}\n{text.strip()}\n{end}\n"
    before = path.read_text(encoding="utf-8") if path.exists() else ""
    if start in before and end in before:
        head, _, rest = before.partition(start)
        _, _, tail = rest.partition(end)
        whole = head + section + tail.lstrip("\n")
    else:
        whole = f"{before.rstrip()}\n\n{section}".lstrip()
    path.write_text(whole, encoding="utf-8")


def commit(*paths: str) -> str:
    """The commit that was run, and whether the files under `paths` differ from it."""
    try:
        run = ["git", "-C", str(ROOT)]
        head = subprocess.run(
            [*run, "rev-parse", "--short", "HEAD"], capture_output=True, text=True, check=True
        ).stdout.strip()
        changed = subprocess.run([*run, "diff", "--quiet", "HEAD", "--", *paths], check=False)
    except (OSError, subprocess.CalledProcessError):
        return "unknown"
    return head + (" with changes" if changed.returncode else "")


def where_and_when(at: str, command: str, seconds: float) -> str:
    """The line that opens a section: machine, date, commit `at`, command, wall time."""
    return (
        f"- {processor()}, {os.cpu_count()} cores, Python {platform.python_version()}; "
        f"{datetime.now(UTC):%Y-%m-%d}, commit {at}; `{command}`; {seconds / 60:.0f} minutes."
    )


@dataclass(frozen=True)
class Part:
    """A section of docs/performance.md that can be measured by itself."""

    name: str
    section: Callable[[bool], str]
    """What was measured, in Markdown; of little where it is asked to be quick."""

    def write(self, docs: Path, quick: bool) -> None:
        """Measure, and put the section into `docs`."""
        text = self.section(quick)
        print(text, flush=True)
        write_section(docs / "performance.md", self.name, text)

    def main(self, purpose: str) -> None:
        """The command line of it alone."""
        parser = argparse.ArgumentParser(description=purpose.splitlines()[0])
        parser.add_argument("--quick", action="store_true", help="of little, into no document")
        if parser.parse_args().quick:
            print(self.section(True))
        else:
            self.write(ROOT / "docs", quick=False)
