"""The API's description is whole, and a studio that runs keeps to it.

The same with ten thousand generated requests: `make soak ONLY=generated`.
"""

from __future__ import annotations

import pkgutil
import re
from collections.abc import Iterator
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

from benchmarks.soak.generated import Running, contents, generate, running
from evastudio.api import models
from evastudio.api.models.common import Given

if TYPE_CHECKING:
    from conftest import Studio

OPENAPI = "/api/v1/openapi.json"
SEED = 6


@pytest.fixture
def furnished(tmp_path: Path) -> Iterator[Running]:
    with running(tmp_path / "generated") as studio:
        yield studio


def test_generated_requests_find_nothing_that_the_description_does_not_tell(
    furnished: Running, tmp_path: Path
) -> None:
    for role, examples, token in (
        ("author", 3, furnished.token),
        ("viewer", 1, furnished.viewer()),
    ):
        folder = tmp_path / role
        folder.mkdir()
        before = contents(furnished.workspace)
        found = generate(
            furnished, token, phases="fuzzing", examples=examples, seed=SEED, folder=folder
        )
        assert found.failures == ()
        assert found.cases > 50
        if role == "viewer":
            assert contents(furnished.workspace) == before


def operations(described: dict[str, Any]) -> Iterator[tuple[str, dict[str, Any]]]:
    for path, methods in described["paths"].items():
        for method, operation in methods.items():
            yield f"{method.upper()} {path}", operation


def test_every_operation_is_described_whole(studio: Studio) -> None:
    described = studio.client.get(OPENAPI).json()
    told = dict(operations(described))
    ids = [operation["operationId"] for operation in told.values()]
    assert len(set(ids)) == len(ids)
    tags = {tag["name"] for tag in described["tags"]}
    for name, operation in told.items():
        assert operation["description"].strip().endswith((".", "`).")), name
        assert set(operation["tags"]) <= tags, name
        answers = operation["responses"]
        assert {"401", "403", "404", "409", "422", "429"} <= set(answers), name
        for status, answer in answers.items():
            problem = "application/problem+json" in answer.get("content", {})
            assert problem == (status >= "400"), f"{name} {status}"
        if "requestBody" in operation:
            assert {"413", "415"} <= set(answers), name
    assert set(described["components"]["securitySchemes"]) == {"bearer", "cookie"}


def test_every_schema_that_is_named_is_there(studio: Studio) -> None:
    answer = studio.client.get(OPENAPI)
    schemas = answer.json()["components"]["schemas"]
    named = set(re.findall(r'"#/components/schemas/([^"]+)"', answer.text))
    assert named <= set(schemas)
    assert "HTTPValidationError" not in schemas


def test_whoever_has_no_token_learns_nothing_of_the_description(studio: Studio) -> None:
    answer = studio.client.get(OPENAPI, headers={"Authorization": "Bearer nobody"})
    assert answer.status_code == 401


@pytest.mark.parametrize(
    ("method", "path", "status", "says"),
    [
        ("GET", "/api/v1/nowhere", 404, "nothing at this address"),
        ("PATCH", "/api/v1/sessions", 405, "takes GET, POST"),
        ("TRACE", "/api/v1/policies/x", 405, "takes DELETE, GET"),
        ("DELETE", "/api/v1/ballots/preferences", 405, "takes GET, not DELETE"),
        ("GET", "/api/v1/ballots/first", 404, "nothing at this address"),
    ],
)
def test_an_address_that_takes_something_else_says_so(
    studio: Studio, method: str, path: str, status: int, says: str
) -> None:
    answer = studio.client.request(method, path)
    assert answer.status_code == status
    assert answer.headers["content-type"] == "application/problem+json"
    assert says in answer.json()["detail"]


@pytest.mark.parametrize(
    ("content", "status", "says"),
    [
        ('{"scene": "asteroids", "name": "a\\u0000b"}', 422, "cannot be kept"),
        ('{"scene": "asteroids", "name": "\\ud800"}', 422, "cannot be kept"),
        ('{"scene": "asteroids", "\\ud800": "x"}', 422, "cannot be kept"),
        ('{"scene": "asteroids", "name": "\\\\u0000"}', 201, ""),
        ('{"scene": ', 422, "JSON"),
        (b'{"scene": "\xff"}', 422, "JSON"),
    ],
)
def test_text_that_no_store_can_hold_is_refused_at_the_edge(
    studio: Studio, content: str | bytes, status: int, says: str
) -> None:
    answer = studio.client.post(
        "/api/v1/sessions", content=content, headers={"Content-Type": "application/json"}
    )
    assert answer.status_code == status, answer.text
    assert says in answer.text


def test_every_example_is_what_its_route_takes() -> None:
    told = 0
    for room in pkgutil.iter_modules(models.__path__):
        module = import_module(f"{models.__name__}.{room.name}")
        for kind in vars(module).values():
            if isinstance(kind, type) and issubclass(kind, Given):
                for example in kind.model_json_schema().get("examples", []):
                    kind.model_validate(example)
                    told += 1
    assert told >= 10
