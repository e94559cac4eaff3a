"""A studio over HTTP, for programs: `Studio(url, token)`.

It knows nothing of the server but its answers, and needs the extra `client`. What is asked for and
cannot be is raised as the same errors as in the studio itself, with its sentence.
"""

from __future__ import annotations

from evastudio.client.evaluations import Evaluation
from evastudio.client.jobs import Job
from evastudio.client.policies import Explanations, Policy
from evastudio.client.scenes import Field, Perception, Scene
from evastudio.client.sessions import Cleaning, Pairs, Session
from evastudio.client.studio import Studio
from evastudio.client.takes import Recording, Take, TakeInProgress
from evastudio.client.worlds import HeadlessWorlds, Seen, Stream

__all__ = [
    "Cleaning",
    "Evaluation",
    "Explanations",
    "Field",
    "HeadlessWorlds",
    "Job",
    "Pairs",
    "Perception",
    "Policy",
    "Recording",
    "Scene",
    "Seen",
    "Session",
    "Stream",
    "Studio",
    "Take",
    "TakeInProgress",
]
