"""Bodies that are not always JSON: read within bounds, and told in what they may come."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, TypeVar

from fastapi import Request
from fastapi.exceptions import RequestValidationError
from pydantic import BaseModel, ValidationError
from pydantic_core import from_json
from starlette.concurrency import run_in_threadpool
from starlette.exceptions import HTTPException

from evastudio.api.arrays import JSON, MOST_BYTES, NPZ, read_npz
from evastudio.world.snapshot import AnyArray

M = TypeVar("M", bound=BaseModel)
MODELS: dict[str, type[BaseModel]] = {}
"""Those that only bodies of several kinds are made of, for the description of the API."""


def media_type(request: Request) -> str:
    """What the body says it is, without its parameters."""
    return request.headers.get("content-type", "").partition(";")[0].strip().lower()


async def read_body(request: Request, most_bytes: int = MOST_BYTES) -> bytes:
    """The body. Raises HTTPException 413 as soon as it is larger than `most_bytes`."""
    data = bytearray()
    async for chunk in request.stream():
        data += chunk
        if len(data) > most_bytes:
            raise HTTPException(
                413, f"The body is larger than {most_bytes // 1_000_000} MB; send less at once."
            )
    return bytes(data)


async def model_or_arrays(request: Request, model: type[M]) -> M | dict[str, AnyArray]:
    """The body as a `model` where it is JSON, as arrays where it is npz; else HTTPException 415."""
    kind = media_type(request)
    if kind == NPZ:
        return await run_in_threadpool(read_npz, await read_body(request))
    if kind != JSON:
        raise wrong_type(kind, JSON, NPZ)
    data = await read_body(request)
    try:
        return await run_in_threadpool(model.model_validate_json, data)
    except ValidationError as error:
        told = [{**one, "loc": ("body", *one["loc"])} for one in error.errors(include_url=False)]
        invalid = any(one["type"] == "json_invalid" for one in told)
        given = None if invalid else await run_in_threadpool(from_json, data)
        raise RequestValidationError(told, body=given) from None


def wrong_type(given: str, *expected: str) -> HTTPException:
    """The refusal of a body of the kind `given`."""
    return HTTPException(
        415, f"The body is said to be {given[:80] or 'nothing'!r}; send {' or '.join(expected)}."
    )


def body_of(model: type[BaseModel], example: Mapping[str, Any] | None = None) -> dict[str, Any]:
    """What OpenAPI says of a body that is a `model` as JSON or arrays as npz."""
    MODELS[model.__name__] = model
    described: dict[str, Any] = {"schema": {"$ref": f"#/components/schemas/{model.__name__}"}}
    if example is not None:
        described["example"] = dict(example)
    binary = {"schema": {"type": "string", "format": "binary"}}
    return {"requestBody": {"required": True, "content": {JSON: described, NPZ: binary}}}
