"""The paper's tables 1 to 3 measured here, in full: writes docs/paper.md and its pictures.

python -m benchmarks.paper            # `evastudio paper` in full, 10 minutes
python -m benchmarks.paper --quick    # to see that it runs; writes nothing into docs/
"""

from __future__ import annotations

import argparse
import os
import shutil
import tempfile
import time
from pathlib import Path

import evastudio
from benchmarks.report import ROOT, commit, where_and_when


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="fewer fields, nothing into docs/")
    parser.add_argument("--jobs", type=int, default=min(2, os.cpu_count() or 1))
    options = parser.parse_args()
    at, began = commit("evastudio", "scenes"), time.monotonic()
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "paper"
        evastudio.paper(
            evastudio.Workspace(Path(folder)), out, quick=options.quick, jobs=options.jobs
        )
        text = (out / "paper.md").read_text(encoding="utf-8")
        told = where_and_when(at, "python -m benchmarks.paper", time.monotonic() - began)
        head, _, rest = text.partition("\n\n")
        text = f"{head}\n\nWritten by `make paper`; do not edit by hand.\n\n{told}\n{rest}"
        print(text)
        if options.quick:
            return
        pictures = ROOT / "docs" / "images" / "paper"
        pictures.mkdir(parents=True, exist_ok=True)
        for picture in out.glob("*.svg"):
            shutil.copy(picture, pictures)
        (ROOT / "docs" / "paper.md").write_text(
            text.replace("](", "](images/paper/"), encoding="utf-8"
        )


if __name__ == "__main__":
    main()
