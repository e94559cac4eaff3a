"""Evaluations: pilots on the same new worlds, compared."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from evastudio.client.connection import Connection
from evastudio.client.jobs import Job
from evastudio.client.reading import read


@dataclass(frozen=True)
class Evaluation:
    """An evaluation that is kept."""

    id: int
    scene: str
    created_at: float
    """Seconds since the epoch."""
    asked: Mapping[str, Any]
    """What makes it again."""
    versions: Mapping[str, str]
    result: Mapping[str, Any]
    """`pilots`: the figures of each, by name; `differences`: of each pair of them."""
    says: Sequence[str] = ()
    """Of each pair of pilots what was found, in words."""


class Evaluations:
    """`studio.evaluations`."""

    def __init__(self, connection: Connection) -> None:
        self._connection = connection

    def __iter__(self) -> Iterator[Evaluation]:
        """All evaluations, newest first."""
        return self.of()

    def of(self, scene: str | None = None) -> Iterator[Evaluation]:
        """Those of one scene where it is given."""
        told = self._connection.pages("/evaluations", scene=scene)
        return (read(Evaluation, one) for one in told)

    def get(self, evaluation: int) -> Evaluation:
        """Raises NotFoundError."""
        return read(Evaluation, self._connection.get(f"/evaluations/{evaluation}"))

    def again(self, evaluation: int) -> Job:
        """Make it again; a job whose result says what differs, bit for bit."""
        return read(Job, self._connection.post(f"/evaluations/{evaluation}/again"))

    def start(
        self,
        scene: str,
        policies: Sequence[str],
        *,
        worlds: int = 100,
        seed: int = 0,
        options: Mapping[str, float] | None = None,
        like: str | None = None,
    ) -> Job:
        """Let policies, or other pilots, act in the same new worlds; a job whose result says as
        `evaluation` which one it became."""
        body: dict[str, Any] = {
            "scene": scene,
            "policies": list(policies),
            "worlds": worlds,
            "seed": seed,
            "options": dict(options or {}),
        }
        if like is not None:
            body["like"] = like
        return read(Job, self._connection.post("/evaluations", body))
