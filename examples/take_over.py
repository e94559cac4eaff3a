"""Watch over a policy, and show it what to do where it has seen nothing like it.

The policy acts in the studio. Where it is far from every demonstration this program takes over for
a second; what it does there becomes takes of a session, to fit the policy to as well.

    python examples/take_over.py "http://127.0.0.1:8400/?token=..." asteroids-careful
"""

from __future__ import annotations

import sys

import numpy as np
from numpy.typing import NDArray

from evastudio.client import Studio

FAR = 0.5
"""Standardised distance to the nearest demonstration from which the policy is not trusted."""
LOOK_EVERY = 5
"""Decisions between two looks."""


def turn(states: NDArray[np.float64]) -> NDArray[np.float64]:
    """Away from what is in the way, and back on course; in the character's own frame."""
    pressure, along, across = states[:, 0], states[:, 4], states[:, 5]
    return np.stack([-0.1 * pressure - 0.05 * along, -0.05 * across], axis=1)


def main(url: str, policy: str) -> None:
    with Studio(url) as studio:
        session = studio.sessions.create("asteroids", f"Corrections of {policy}", "a rule")
        with studio.worlds.open("asteroids", [7], session=session.id, pilot="rule") as worlds:
            second = round(1.0 / worlds.dt_s)
            seen = worlds.observe()
            while not seen.ended:
                distance = studio.policies.explain(policy, seen.states).distances[0, 0]
                if distance < FAR:
                    seen = worlds.play(policy, LOOK_EVERY)
                    continue
                for _ in range(second):
                    seen = worlds.step(turn(seen.states), frame="own")
        session = studio.sessions.get(session.id)
        print(f"{policy} {seen.outcomes[0]} after {seen.steps[0]} decisions")
        print(f"{session.takes_kept} corrections, {session.pairs} pairs, in {session.name!r}")


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2])
