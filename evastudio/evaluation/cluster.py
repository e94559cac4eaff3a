"""The same work on many machines: joblib's tasks on a Dask cluster, where one is named."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator, Mapping
from contextvars import ContextVar
from typing import TYPE_CHECKING, TypeVar, cast

import joblib

from evastudio.errors import ClusterError
from evastudio.evaluation.versions import code, versions

if TYPE_CHECKING:
    from distributed import Client

T = TypeVar("T")
_client: ContextVar[Client | None] = ContextVar("cluster", default=None)
"""Of the cluster that work goes to now, if any."""
PATIENCE_S = 10.0
"""How long to wait for a cluster's scheduler, and for its first worker."""


@contextlib.contextmanager
def on_cluster(address: str | None, patience_s: float = PATIENCE_S) -> Iterator[int]:
    """Within it, whatever goes through joblib runs on the cluster at `address`, tcp://HOST:PORT.

    Gives the number of processes to ask joblib for: -1 for all there are; where `address` is
    None nothing changes, and it is 1. A worker that dies costs time: its tasks are done again by
    another. Raises ClusterError where the extra `cluster` is not installed, nobody answers, no
    worker is there, or a worker has other versions than this process.
    """
    if address is None:
        yield 1
        return
    try:
        from distributed import Client
        from joblib._dask import DaskDistributedBackend
    except ImportError:
        raise ClusterError(
            "Running on a cluster needs Dask; install it with: pip install 'evastudio[cluster]'."
        ) from None

    class Everywhere(DaskDistributedBackend):  # type: ignore[misc]
        """joblib keeps the work to itself where it may do one thing at a time: never here."""

        def effective_n_jobs(self, n_jobs: int) -> int:
            return max(2, int(super().effective_n_jobs(n_jobs)))

    try:
        client = Client(address, timeout=patience_s, set_as_default=True)
    except (OSError, ValueError, TypeError) as error:
        raise ClusterError(
            f"No Dask scheduler answers at {address!r} ({str(error) or type(error).__name__}). "
            "Start one with `dask scheduler` and give its address, like tcp://10.0.0.5:8786."
        ) from None
    with client:
        try:
            client.wait_for_workers(1, timeout=patience_s)
        except TimeoutError:
            raise ClusterError(
                f"The cluster at {address} has no worker. Start some with `dask worker {address}`."
            ) from None
        try:
            found = client.run(_installed)
        except (ImportError, AttributeError):
            raise ClusterError(
                f"A worker of the cluster at {address} does not have evastudio, or an old one. "
                f"Install evastudio {versions()['evastudio']} there and start it again."
            ) from None
        _agree(found, address)
        token = _client.set(client)
        try:
            with joblib.parallel_config(backend=Everywhere(client=client), n_jobs=-1):
                yield -1
        finally:
            _client.reset(token)


def once(thing: T) -> T:
    """Stands for `thing` in the arguments of joblib's tasks; `thing` itself without a cluster.

    On one it reaches each worker once, not with every task, and again if the worker dies: it is a
    task of its own, which the scheduler can have done anew. Keep it until the work is done. Raises
    ClusterError where a worker cannot read it.
    """
    client = _client.get()
    if client is None:
        return thing
    sent = client.submit(_itself, thing, pure=False)
    # A task that is given what cannot be had would wait for ever.
    if (error := sent.exception()) is not None:
        raise ClusterError(
            f"A worker cannot read the {type(thing).__name__} it was sent ({error}). Whatever it "
            "is made of must be installed there too."
        ) from None
    return cast("T", sent)


def _installed() -> dict[str, str]:
    return {**versions(), "its code": code()}


def _itself(thing: T) -> T:
    return thing


def _agree(workers: Mapping[str, Mapping[str, str]], address: str) -> None:
    ours = _installed()
    for worker, theirs in workers.items():
        other = [
            f"{name} {theirs.get(name)} (here {mine})"
            for name, mine in ours.items()
            if theirs.get(name) != mine
        ]
        if other:
            raise ClusterError(
                f"The worker {worker} of the cluster at {address} has other versions: "
                f"{', '.join(other)}. Results would not repeat; install the same there and start "
                "it again."
            )
