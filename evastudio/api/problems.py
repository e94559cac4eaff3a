"""Errors over HTTP: RFC 9457 problem+json with the sentence a person can read."""

from __future__ import annotations

import logging

from fastapi import FastAPI, Request
from fastapi.exceptions import RequestValidationError
from starlette.exceptions import HTTPException
from starlette.responses import JSONResponse, Response

from evastudio.errors import (
    ConflictError,
    InvalidInputError,
    NotFoundError,
    StorageError,
    StudioError,
)

logger = logging.getLogger(__name__)

STATUS: tuple[tuple[type[StudioError], int, str], ...] = (
    (NotFoundError, 404, "Not found"),
    (ConflictError, 409, "Not possible now"),
    (InvalidInputError, 422, "Invalid input"),
    (StorageError, 409, "Storage problem"),
)


def problem_response(status: int, title: str, detail: str) -> Response:
    """One problem as the body of a response."""
    body = {"type": "about:blank", "title": title, "status": status, "detail": detail}
    return JSONResponse(body, status_code=status, media_type="application/problem+json")


def install(app: FastAPI) -> None:
    """Answer every error of `app` as a problem."""

    @app.exception_handler(StudioError)
    async def studio_error(_: Request, error: StudioError) -> Response:
        for kind, status, title in STATUS:
            if isinstance(error, kind):
                return problem_response(status, title, str(error))
        return problem_response(400, "Not possible", str(error))

    @app.exception_handler(RequestValidationError)
    async def invalid(_: Request, error: RequestValidationError) -> Response:
        told = "; ".join(
            f"{'.'.join(str(part) for part in one['loc'][1:]) or 'body'}: {one['msg']}"
            for one in error.errors()[:5]
        )
        return problem_response(422, "Invalid input", told)

    @app.exception_handler(HTTPException)
    async def http_error(_: Request, error: HTTPException) -> Response:
        response = problem_response(error.status_code, "Request refused", str(error.detail))
        response.headers.update(error.headers or {})
        return response

    @app.exception_handler(Exception)
    async def unexpected(_: Request, error: Exception) -> Response:
        logger.error("A request failed", exc_info=error)
        return problem_response(
            500, "Failed", "This did not work, for a reason that the server's log tells."
        )
