"""Jobs over HTTP, field by field."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from evastudio.api.models.common import Model


class JobOut(Model):
    id: int
    kind: str
    session: int | None
    state: str
    progress: float
    message: str
    result: Mapping[str, Any] | None
    error: str | None
    request: str | None
    """Id of the request that asked for it (X-Request-ID)."""
