"""What a stage's thread does, at times that a test gives."""

from __future__ import annotations

from evastudio.live.stage import Stage


def run(stage: Stage, start: float, seconds: float, every: float = 0.004) -> float:
    """Advance the stage for `seconds`, in small steps of the clock; when it is then."""
    count = round(seconds / every)
    for step in range(1, count + 1):
        stage.advance(start + step * every, 0.0)
    return start + count * every
