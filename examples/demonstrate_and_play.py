"""A program demonstrates, the studio cleans and fits, and the policy flies on alone.

evastudio                                          # prints its address
python examples/demonstrate_and_play.py "http://127.0.0.1:8400/?token=..."
"""

from __future__ import annotations

import sys

import numpy as np
from numpy.typing import NDArray

from evastudio.client import Job, Studio

NAME = "a-programs-way"
FLIGHTS = range(1, 5)
UNSEEN = range(100, 110)


def turn(states: NDArray[np.float64]) -> NDArray[np.float64]:
    """Away from what is in the way, and back on course; in the character's own frame."""
    pressure, along, across = states[:, 0], states[:, 4], states[:, 5]
    return np.stack([-0.1 * pressure - 0.05 * along, -0.05 * across], axis=1)


def tell(job: Job) -> None:
    print(f"  {job.kind} {job.progress:4.0%} {job.message}")


def main(url: str) -> None:
    with Studio(url) as studio:
        session = studio.sessions.create("asteroids", "A program's way", "a rule of two lines")
        with (
            studio.worlds.open("asteroids", [0], session=session.id, pilot="rule") as worlds,
            worlds.stream(frame="own") as stream,
        ):
            for seed in FLIGHTS:
                seen = stream.reset([seed])
                while not seen.ended:
                    seen = stream.step(turn(seen.states))
                print(f"Flight {seed}: {seen.outcomes[0]} after {seen.steps[0]} decisions")

        cleaned = studio.jobs.wait(studio.sessions.clean(session.id), tell)
        assert cleaned.result is not None
        print(f"{cleaned.result['removed']} of {cleaned.result['pairs']} pairs contradict others")
        studio.jobs.wait(studio.sessions.fit(session.id, name=NAME, learner="knn"), tell)

        with studio.worlds.open("asteroids", UNSEEN) as worlds:
            seen = worlds.play(NAME, 1000)
        crossed = seen.outcomes.count("crossed")
        print(f"{NAME} crossed {crossed} of {len(UNSEEN)} fields it has never seen")


if __name__ == "__main__":
    main(sys.argv[1])
