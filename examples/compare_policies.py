"""Compare every policy of a scene on the same new worlds, and print what was found.

python examples/compare_policies.py "http://127.0.0.1:8400/?token=..." asteroids 20
"""

from __future__ import annotations

import sys

from evastudio.client import Studio


def main(url: str, scene: str, worlds: int) -> None:
    with Studio(url) as studio:
        names = [policy.name for policy in studio.policies.of(scene) if policy.problem is None]
        job = studio.evaluations.start(scene, [*names, "straight"], worlds=worlds)
        done = studio.jobs.wait(job)
        assert done.result is not None
        found = studio.evaluations.get(done.result["evaluation"])
        for name, figures in found.result["pilots"].items():
            print(f"{name:24} succeeded in {figures['succeeded']} of {worlds}")
        for sentence in found.says:
            print(sentence)


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2], int(sys.argv[3]))
