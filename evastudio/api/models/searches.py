"""Searches for policies over HTTP, field by field."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import ConfigDict, Field

from evastudio.api.models.common import Given, Name, Options, PolicyName, Seed


class SearchIn(Given):
    """As `evastudio search`: PEGASUS, with no demonstration."""

    model_config = ConfigDict(
        json_schema_extra={
            "examples": [{"scene": "asteroids", "rounds": 2, "scenarios": 2, "horizon_s": 2.0}]
        }
    )

    scene: Name
    optimiser: Literal["cma-es", "hill-climbing"] = "cma-es"
    hidden: Annotated[int, Field(ge=1, le=256)] = 8
    """Hidden units of the network."""
    scenarios: Annotated[int, Field(ge=1, le=10_000)] = 24
    """Fixed worlds to try in."""
    horizon_s: Annotated[float, Field(ge=0.1, le=3600.0)] = 24.0
    """Seconds flown in each."""
    population: Annotated[int, Field(ge=4, le=4096)] = 32
    """Networks tried in a round."""
    rounds: Annotated[int, Field(ge=1, le=10_000)] = 30
    spread: Annotated[float, Field(gt=0.0, le=100.0)] = 0.15
    """Of the weights tried first."""
    loss: Annotated[float, Field(ge=0.0, le=1000.0)] = 0.5
    """What it costs to fail."""
    calm: Annotated[float, Field(ge=0.0, le=1000.0)] = 0.5
    """What changes of action cost."""
    seed: Seed = 0
    perception: Name | None = None
    options: Options
    name: PolicyName | None = None
