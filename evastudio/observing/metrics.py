"""Metrics for Prometheus: counts and times of a running studio, none with a name or a token."""

from __future__ import annotations

import time
from collections import Counter as Counted
from collections.abc import Callable, Iterator, Mapping

from prometheus_client import (
    CollectorRegistry,
    Counter,
    Gauge,
    Histogram,
    ProcessCollector,
    disable_created_metrics,
    generate_latest,
)
from prometheus_client.core import CounterMetricFamily, GaugeMetricFamily, HistogramMetricFamily
from prometheus_client.registry import Collector

from evastudio.live.jobs import ENDED, Job, Jobs, JobState
from evastudio.live.stages import Stages
from evastudio.live.status import Phase
from evastudio.live.tally import BOUNDS_S

disable_created_metrics()  # type: ignore[no-untyped-call]  # when each series began
CONTENT_TYPE = "text/plain; version=0.0.4; charset=utf-8"
QUICK_S = (0.001, 0.0025, 0.005, 0.01, 0.025, 0.05, 0.1, 0.25, 0.5, 1.0, 2.5, 5.0, 10.0)
LONG_S = (0.5, 1.0, 2.0, 5.0, 10.0, 30.0, 60.0, 120.0, 300.0, 600.0, 1800.0)


class Metrics:
    """The metrics of one studio. May be counted on from any thread."""

    def __init__(self) -> None:
        self._registry = made = CollectorRegistry()
        ProcessCollector(registry=made)
        self.requests = Counter(
            "evastudio_requests",
            "Requests answered and websockets ended, by route as the program has it.",
            ("method", "route", "status"),
            registry=made,
        )
        self.request_seconds = Histogram(
            "evastudio_request_seconds",
            "Time to answer a request over HTTP.",
            ("route",),
            buckets=QUICK_S,
            registry=made,
        )
        self.sockets = Gauge(
            "evastudio_sockets",
            "Clients: websockets open now, by route.",
            ("route",),
            registry=made,
        )
        self._store_seconds = Histogram(
            "evastudio_store_seconds",
            "Time that the store took: statements by kind, and transactions whole.",
            ("operation",),
            buckets=QUICK_S,
            registry=made,
        )
        self._job_seconds = Histogram(
            "evastudio_job_seconds",
            "Time from a job's start to its end.",
            ("kind", "state"),
            buckets=LONG_S,
            registry=made,
        )
        self._running: dict[int, float] = {}

    def store_took(self, operation: str, seconds: float) -> None:
        """The store did something; see `watch_store`."""
        self._store_seconds.labels(operation).observe(seconds)

    def job_changed(self, job: Job) -> None:
        """A job stands otherwise than before."""
        now = time.monotonic()
        if job.state is JobState.RUNNING:
            self._running.setdefault(job.id, now)
        elif job.state in ENDED:
            seconds = now - self._running.pop(job.id, now)
            self._job_seconds.labels(job.kind, job.state.value).observe(seconds)

    def look_at(self, stages: Stages, jobs: Jobs, outgoing: Callable[[], int]) -> None:
        """Tell of these too. `outgoing` is how many messages wait for clients."""
        self._registry.register(_Looked(stages, jobs, outgoing))

    def told(self) -> bytes:
        """Everything, as Prometheus reads it."""
        return generate_latest(self._registry)


class _Looked(Collector):
    """What is known elsewhere, looked up when it is asked for."""

    def __init__(self, stages: Stages, jobs: Jobs, outgoing: Callable[[], int]) -> None:
        self._stages = stages
        self._jobs = jobs
        self._outgoing = outgoing

    def collect(
        self,
    ) -> Iterator[CounterMetricFamily | GaugeMetricFamily | HistogramMetricFamily]:
        tally = self._stages.tally()
        yield CounterMetricFamily("evastudio_steps", "Decisions that fell.", tally.steps)
        yield CounterMetricFamily(
            "evastudio_late_steps",
            "Decisions over half a step late, or left out.",
            tally.late_steps,
        )
        yield HistogramMetricFamily(
            "evastudio_step_lateness_seconds",
            "How long after its time a decision began.",
            buckets=_cumulated(tally.by_lateness),
            sum_value=tally.seconds,
        )
        stages, jobs = self._stages.all(), self._jobs.all()
        yield _gauge(
            "evastudio_stages",
            "Stages open now, by what they do.",
            "phase",
            _counted(Phase, [stage.phase for stage in stages]),
        )
        yield _gauge(
            "evastudio_jobs",
            "Jobs remembered, by how they stand.",
            "state",
            _counted(JobState, [job.state for job in jobs]),
        )
        waiting = {
            "recorder": sum(stage.backlog for stage in stages),
            "jobs": sum(job.state is JobState.QUEUED for job in jobs),
            "sockets": self._outgoing(),
        }
        yield _gauge(
            "evastudio_queue_length",
            "Chunks of takes not yet in the store, jobs not yet begun, messages not yet sent.",
            "queue",
            waiting,
        )


def _cumulated(counts: list[int]) -> list[tuple[str, float]]:
    told, below = [], 0
    for bound, count in zip((*map(str, BOUNDS_S), "+Inf"), counts, strict=True):
        below += count
        told.append((bound, float(below)))
    return told


def _counted(
    kinds: type[Phase] | type[JobState], present: list[Phase] | list[JobState]
) -> dict[str, int]:
    found = Counted(one.value for one in present)
    return {kind.value: found[kind.value] for kind in kinds}


def _gauge(name: str, help: str, label: str, values: Mapping[str, float]) -> GaugeMetricFamily:  # noqa: A002
    family = GaugeMetricFamily(name, help, labels=(label,))
    for value, number in values.items():
        family.add_metric((value,), number)
    return family
