"""The description of the API, as OpenAPI: complete, so that programs can be made from it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from importlib.metadata import version
from typing import Any

from fastapi import FastAPI
from fastapi.openapi.utils import get_openapi
from pydantic import BaseModel
from pydantic.json_schema import models_json_schema

from evastudio.api import bodies
from evastudio.api.models.asking import DecisionsOut, ExplanationsOut
from evastudio.api.models.pairs import PairsOut
from evastudio.api.models.takes import RecordingOut
from evastudio.api.problems import PROBLEM

ADDED: tuple[type[BaseModel], ...] = (DecisionsOut, ExplanationsOut, RecordingOut, PairsOut)
"""Answers that are written by hand, for they can be arrays."""
REFS = "#/components/schemas/{model}"
TAGS = {
    "scenes": "What characters there are, what they perceive and can do.",
    "sessions": "The takes one demonstrator made of one scene, and the work on them.",
    "takes": "Demonstrations: made by a program, thrown away, brought back, read.",
    "policies": "What was fitted or written: taken, put, asked what it would do and why.",
    "evaluations": "Pilots compared on the same worlds.",
    "studies": "What people needed and preferred, where they agreed that it is kept.",
    "lineups": "Runs of one world side by side, on one timeline.",
    "ballots": "Two runs without names: which is livelier?",
    "films": "Runs and takes as files to hand on.",
    "making": "Sessions and policies made with nobody at the keys.",
    "access": "Who one is here.",
    "pilots": "Who can act in a scene.",
    "worlds": "Headless worlds, for programs.",
    "clips": "How people move.",
    "jobs": "Work in the background.",
    "stages": "Live worlds that somebody drives.",
}
EVERYWHERE = {
    401: "No token, or one that is not known.",
    403: "The token's role, or the page the request came from, does not allow this.",
    404: "Something that was named does not exist.",
    409: "Not possible as things stand, or the store cannot be used now.",
    414: "The address is too long.",
    421: "The request was meant for another host.",
    422: "What was given cannot be used; the detail says why.",
    429: "Too much at once; wait as Retry-After says.",
    503: "The studio has too much to do, or shuts down; try again.",
}
WITH_BODY = {
    413: "The body is larger than is read.",
    415: "The body is of a kind that is not read here.",
}
REPEATED = {
    "name": "Idempotency-Key",
    "in": "header",
    "required": False,
    "description": "A request that was answered with success is not done again when it comes again "
    "with the same key within a day: it is answered as before. Another request with that key is "
    "422; one that comes while the first is not answered yet is 409.",
    "schema": {"type": "string", "minLength": 1, "maxLength": 200, "pattern": "^[!-~]+$"},
}
ASKING = ("decide", "explain")
"""What is posted only to ask; it changes nothing, so it can be repeated anyway."""
MATCHED = {412: "What is there is not what If-Match names."}


def describe(app: FastAPI) -> None:
    """Let `app.openapi()` tell all of it."""

    def openapi() -> dict[str, Any]:
        if app.openapi_schema is None:
            app.openapi_schema = _described(app)
        return app.openapi_schema

    app.openapi = openapi  # type: ignore[method-assign]


def _described(app: FastAPI) -> dict[str, Any]:
    told = get_openapi(
        title=app.title,
        version=version("evastudio"),
        summary="Demonstrate, clean, fit, play and compare, with no page.",
        routes=app.routes,
        tags=[{"name": name, "description": about} for name, about in TAGS.items()],
    )
    components = told.setdefault("components", {})
    schemas = components.setdefault("schemas", {})
    for name in ("HTTPValidationError", "ValidationError"):
        schemas.pop(name, None)
    models = [*ADDED, *bodies.MODELS.values()]
    _, more = models_json_schema([(one, "validation") for one in models], ref_template=REFS)
    schemas.update(more.get("$defs", {}))
    schemas["Problem"] = PROBLEM
    components["securitySchemes"] = {
        "bearer": {"type": "http", "scheme": "bearer", "description": "An access token."},
        "cookie": {
            "type": "apiKey",
            "in": "cookie",
            "name": "evastudio",
            "description": "As set by the address that the studio prints; the name ends in "
            "-PORT. Writing asks for an Origin header of this studio too.",
        },
    }
    told["security"] = [{"bearer": []}, {"cookie": []}]
    for method, operation in _operations(told):
        if method == "post" and operation["operationId"] not in ASKING:
            operation.setdefault("parameters", []).append(REPEATED)
        _complete(operation)
    return told


def _operations(told: Mapping[str, Any]) -> Iterator[tuple[str, dict[str, Any]]]:
    for path in told["paths"].values():
        yield from path.items()


def _complete(operation: dict[str, Any]) -> None:
    """Add the refusals that every operation of its kind can meet."""
    refusals = dict(EVERYWHERE)
    if "requestBody" in operation:
        refusals |= WITH_BODY
    if any(one["name"].lower() == "if-match" for one in operation.get("parameters", [])):
        refusals |= MATCHED
    for status, why in refusals.items():
        operation["responses"][str(status)] = {
            "description": why,
            "content": {
                "application/problem+json": {"schema": {"$ref": "#/components/schemas/Problem"}}
            },
        }
    operation["responses"] = dict(sorted(operation["responses"].items()))
