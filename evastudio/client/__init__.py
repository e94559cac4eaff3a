"""A studio over HTTP, for programs: `Studio(url, token)`.

It knows nothing of the server but its answers, and needs the extra `client`. What is asked for and
cannot be is raised as the same errors as in the studio itself, with its sentence.
"""

from __future__ import annotations

from evastudio.client.ballots import Ballot, Preference, Vote
from evastudio.client.evaluations import Evaluation
from evastudio.client.films import Film
from evastudio.client.jobs import Job
from evastudio.client.lineups import Column, Lineup, Standing
from evastudio.client.policies import Explanations, Policy
from evastudio.client.scenes import Field, Perception, Scene
from evastudio.client.sessions import Cleaning, Pairs, Session
from evastudio.client.studies import Study
from evastudio.client.studio import Studio
from evastudio.client.takes import Recording, Take, TakeInProgress
from evastudio.client.worlds import HeadlessWorlds, Seen, Stream

__all__ = [
    "Ballot",
    "Cleaning",
    "Column",
    "Evaluation",
    "Explanations",
    "Field",
    "Film",
    "HeadlessWorlds",
    "Job",
    "Lineup",
    "Pairs",
    "Perception",
    "Policy",
    "Preference",
    "Recording",
    "Scene",
    "Seen",
    "Session",
    "Standing",
    "Stream",
    "Studio",
    "Study",
    "Take",
    "TakeInProgress",
    "Vote",
]
