"""Routes: what a policy would do, and why."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, Literal

import numpy as np
from fastapi import APIRouter, Depends, Query, Request, Response
from pydantic import BaseModel

from evastudio.api.arrays import JSON, NPZ, as_json, npz
from evastudio.api.bodies import body_of, model_or_arrays
from evastudio.api.context import Studio
from evastudio.api.downloads import BINARY
from evastudio.api.limits import MOST_UPLOAD_BYTES
from evastudio.api.models.asking import MOST_ASKED, DecideIn, ExplainIn
from evastudio.errors import InvalidInputError
from evastudio.learning.policy import Policy
from evastudio.live import asking
from evastudio.world.snapshot import AnyArray

router = APIRouter(prefix="/policies", tags=["policies"])

MOST_ROWS = 200_000
"""States that can be asked about at once as npz."""
Form = Annotated[Literal["json", "npz"], Query(alias="format")]


async def _decide_body(request: Request) -> DecideIn | dict[str, AnyArray]:
    return await model_or_arrays(request, DecideIn)


async def _explain_body(request: Request) -> ExplainIn | dict[str, AnyArray]:
    return await model_or_arrays(request, ExplainIn)


def _asked(answer: str, body: type[BaseModel]) -> dict[str, Any]:
    """What a route declares that takes states and answers, both as JSON or as npz."""
    told = {"schema": {"$ref": f"#/components/schemas/{answer}"}}
    return {
        "max_body_size": MOST_UPLOAD_BYTES,
        "response_class": Response,
        "responses": {200: {"description": "The answer.", "content": {JSON: told, NPZ: BINARY}}},
        "openapi_extra": body_of(body, {"states": [[0.0] * 6]}),
    }


@router.post("/{name}/decide", **_asked("DecisionsOut", DecideIn))
def decide(
    name: str,
    body: Annotated[DecideIn | dict[str, AnyArray], Depends(_decide_body)],
    studio: Studio,
    form: Form = "json",
) -> Response:
    """What a policy does in these states, or at these moments of a take. Nothing is changed.

    The body is JSON, or npz with `states` (rows, n); the answer is JSON, or npz with `actions`.
    """
    policy = studio.shelf.policy(name)
    if isinstance(body, DecideIn) and body.moments is not None:
        steps = np.array(body.moments.steps, dtype=np.int64)
        actions = asking.decide_in_take(
            studio.workspace, studio.store, policy, body.moments.take, steps
        )
    else:
        states = _states(body.states if isinstance(body, DecideIn) else body, MOST_ROWS)
        actions = asking.decide(policy, states, body.seed if isinstance(body, DecideIn) else None)
    if form == "npz":
        return Response(npz({"actions": actions}), media_type=NPZ)
    fields = ["symbol"] if _symbolic(policy) else list(policy.action.names)
    told = {
        "actions": actions,
        "fields": fields,
        "symbols": asking.symbols_of(policy, actions),
    }
    return Response(as_json(told), media_type=JSON)


@router.post("/{name}/explain", **_asked("ExplanationsOut", ExplainIn))
def explain(
    name: str,
    body: Annotated[ExplainIn | dict[str, AnyArray], Depends(_explain_body)],
    studio: Studio,
    form: Form = "json",
) -> Response:
    """Which moments of demonstrations a policy's decisions come from. Nothing is changed.

    As npz: `takes`, `steps` (-1 where the file does not tell), `distances`, `weights`, each
    (states, neighbours), nearest first, and `agreement` (states,).
    """
    policy = studio.shelf.policy(name)
    states = _states(body.states if isinstance(body, ExplainIn) else body, MOST_ASKED)
    found = asking.sources(policy, states)
    if form == "npz":
        arrays = {
            "takes": found.takes,
            "steps": found.steps,
            "distances": found.distances,
            "weights": found.weights,
        }
        if found.agreement is not None:
            arrays["agreement"] = found.agreement
        return Response(npz(arrays), media_type=NPZ)
    return Response(as_json(_explanations(policy, found)), media_type=JSON)


def _explanations(policy: Policy, found: asking.Sources) -> dict[str, object]:
    """As `ExplanationsOut`."""
    lists = [array.tolist() for array in (found.takes, found.steps, found.distances, found.weights)]
    told = []
    for row, (takes, steps, distances, weights) in enumerate(zip(*lists, strict=True)):
        neighbors = [
            {
                "take": None if take == asking.NOWHERE else take,
                "step": None if take == asking.NOWHERE else step,
                "distance": distance,
                "weight": weight,
            }
            for take, step, distance, weight in zip(takes, steps, distances, weights, strict=True)
        ]
        agreed = None if found.agreement is None else float(found.agreement[row])
        told.append({"neighbors": neighbors, "nearest": distances[0], "agreement": agreed})
    return {"session": policy.session, "explanations": told}


def _states(given: list[list[float]] | Mapping[str, AnyArray] | None, most: int) -> AnyArray:
    if isinstance(given, Mapping):
        if set(given) != {"states"}:
            raise InvalidInputError(
                f"The arrays are {', '.join(sorted(given)) or 'none'}; expected states alone."
            )
        states = given["states"]
    else:
        try:
            states = np.array(given, dtype=np.float64)
        except ValueError:
            raise InvalidInputError("The rows of states differ in length.") from None
    if not len(states.reshape(-1)) > 0 or len(states) > most:
        raise InvalidInputError(f"Ask about 1 to {most} states at once.")
    return np.asarray(states, dtype=np.float64)


def _symbolic(policy: Policy) -> bool:
    return len(policy.action.names) != policy.action.size
