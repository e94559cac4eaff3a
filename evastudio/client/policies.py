"""Policies: listed, taken and put as files, and asked what they would do and why."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from evastudio.client.connection import BINARY, Connection
from evastudio.client.jobs import Job
from evastudio.client.reading import read

JSON = "application/json"
SWITCH = ".switch.json"


@dataclass(frozen=True)
class Policy:
    """A policy or a switch, as the studio lists it."""

    name: str
    scene: str | None
    scene_version: int | None
    perception: str | None
    learner: str | None
    settings: Mapping[str, Any]
    pairs: int | None
    session: str | None
    """Name of the session it was fitted to."""
    report: Sequence[str]
    """What fitting or tuning said of it, for people."""
    switches: Sequence[str]
    """The policies of a switch; empty for a policy."""
    made_by: str | None
    created: str | None
    shipped: bool
    stale: bool
    """The session's pairs have changed since it was fitted."""
    problem: str | None
    """Why it cannot play, or None."""
    made_before: str | None = None
    """What has changed in its session since, as "made before 2 takes were added"; or None."""
    in_short: Sequence[str] = ()
    """The report without fields of the state and their figures."""


@dataclass(frozen=True)
class Explanations:
    """The moments of demonstrations that decisions come from, nearest first."""

    takes: NDArray[np.int64]
    """(states, neighbours); -1 where the policy's file does not tell."""
    steps: NDArray[np.int64]
    distances: NDArray[np.float64]
    """How far the states shown there are from those asked about, standardised."""
    weights: NDArray[np.float64]
    """How much each counted; those of one state sum to 1."""
    agreement: NDArray[np.float64] | None = None
    """1 where the neighbours agree, 0 where they differ as all pairs do, (states,)."""


class Policies:
    """`studio.policies`."""

    def __init__(self, connection: Connection) -> None:
        self._connection = connection

    def __iter__(self) -> Iterator[Policy]:
        """All policies and switches."""
        return self.of()

    def of(self, scene: str | None = None) -> Iterator[Policy]:
        """Those of one scene where it is given."""
        return (read(Policy, told) for told in self._connection.pages("/policies", scene=scene))

    def get(self, name: str) -> Policy:
        """Raises NotFoundError."""
        return read(Policy, self._connection.get(f"/policies/{name}"))

    def decide(self, name: str, states: ArrayLike) -> NDArray[np.float64]:
        """What it does in these states (rows, n), in the character's own frame: (rows, m).

        For one that draws by chance, what was shown most often there.
        """
        given = {"states": np.asarray(states, dtype=np.float64)}
        return self._connection.arrays("POST", f"/policies/{name}/decide", given, again=True)[
            "actions"
        ]

    def explain(self, name: str, states: ArrayLike) -> Explanations:
        """Which moments of demonstrations its decisions in these states (rows, n) come from."""
        given = {"states": np.asarray(states, dtype=np.float64)}
        found = self._connection.arrays("POST", f"/policies/{name}/explain", given, again=True)
        return read(Explanations, found)

    def download(self, name: str, folder: str | Path) -> Path:
        """Keep its file in `folder`, under the name it has in the studio; where it is."""
        answer = self._connection.send("GET", f"/policies/{name}/file")
        switch = answer.headers["content-type"].startswith(JSON)
        path = Path(folder) / f"{name}{SWITCH if switch else '.safetensors'}"
        path.write_bytes(answer.content)
        return path

    def upload(self, path: str | Path, name: str | None = None, *, replace: bool = False) -> Policy:
        """Keep the file of a policy or switch in the studio, under its own name or `name`.

        Raises ConflictError where the name is taken and the other is not to be replaced,
        InvalidInputError or StorageError for what is no policy.
        """
        file = Path(path)
        switch = file.name.endswith(SWITCH)
        name = name or file.name.removesuffix(SWITCH).removesuffix(".safetensors")
        headers = {"Content-Type": JSON if switch else BINARY}
        if replace:
            there = self._connection.send("GET", f"/policies/{name}/file")
            headers["If-Match"] = there.headers["etag"]
        answer = self._connection.send(
            "PUT", f"/policies/{name}/file", headers=headers, content=file.read_bytes()
        )
        return read(Policy, answer.json())

    def delete(self, name: str) -> None:
        """Delete it for good; the takes it was fitted to stay. Raises ConflictError for one that
        is shipped or that a switch needs."""
        self._connection.delete(f"/policies/{name}")

    def switch(
        self, name: str, entries: Sequence[tuple[str, str | None]], perception: str | None = None
    ) -> Job:
        """Make a switch between policies: pairs of a policy and the condition under which it acts,
        None for the last; a job."""
        body: dict[str, Any] = {
            "name": name,
            "entries": [{"policy": policy, "when": when} for policy, when in entries],
        }
        if perception is not None:
            body["perception"] = perception
        return read(Job, self._connection.post("/switches", body))
