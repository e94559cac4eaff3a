"""Runs what takes long and writes docs/reliability.md.

python -m benchmarks.soak                   # everything
python -m benchmarks.soak --only kills      # one part
python -m benchmarks.soak --quick           # little of each, to see that it runs; writes nothing
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Mapping
from importlib import import_module

PARTS: Mapping[str, str] = {
    "generated": "benchmarks.soak.generated",
    "kills": "benchmarks.soak.kills",
    "load": "benchmarks.soak.load",
    "hour": "benchmarks.soak.hour",
    "response": "benchmarks.soak.response",
    "animators": "benchmarks.soak.animators",
    "fitting": "benchmarks.soak.fitting",
}
"""Names for --only, and the modules that hold them, in the order in which they run. Each has a
function `run(quick: bool, seed: int) -> bool`: it prints its figures, writes its section of
docs/reliability.md unless `quick`, and says whether what is required held."""


def main() -> int:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.soak")
    parser.add_argument("--only", choices=PARTS)
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--seed", type=int, default=6)
    given = parser.parse_args()
    names = [given.only] if given.only else list(PARTS)
    held = [import_module(PARTS[name]).run(given.quick, given.seed) for name in names]
    return 0 if all(held) else 1


if __name__ == "__main__":
    sys.exit(main())
