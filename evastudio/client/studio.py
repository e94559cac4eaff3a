"""A studio, as a program far from it uses it."""

from __future__ import annotations

from evastudio.client.ballots import Ballots
from evastudio.client.connection import Connection
from evastudio.client.evaluations import Evaluations
from evastudio.client.films import Films
from evastudio.client.jobs import Jobs
from evastudio.client.lineups import Lineups
from evastudio.client.policies import Policies
from evastudio.client.scenes import Scenes
from evastudio.client.sessions import Sessions
from evastudio.client.studies import Studies
from evastudio.client.takes import Takes
from evastudio.client.worlds import Worlds

TIMEOUT_S = 60.0


class Studio:
    """A studio over HTTP. Safe to use from several threads; use it in a `with` block."""

    def __init__(self, url: str, token: str | None = None, *, timeout_s: float = TIMEOUT_S) -> None:
        """`url` may be the address that the studio printed, token included. Nothing is asked yet.

        Raises InvalidInputError for what is no address, or where there is no token.
        """
        self._connection = Connection(url, token, timeout_s)
        self.scenes = Scenes(self._connection)
        self.sessions = Sessions(self._connection)
        self.takes = Takes(self._connection)
        self.policies = Policies(self._connection)
        self.evaluations = Evaluations(self._connection)
        self.lineups = Lineups(self._connection)
        self.ballots = Ballots(self._connection)
        self.films = Films(self._connection)
        self.studies = Studies(self._connection)
        self.jobs = Jobs(self._connection)
        self.worlds = Worlds(self._connection)

    def __enter__(self) -> Studio:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Let go of the connections; worlds that are open stay so until left alone too long."""
        self._connection.close()
