"""Films: takes, and what happened on a stage, as files to hand on."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

from evastudio.client.connection import Connection
from evastudio.client.jobs import Job
from evastudio.client.reading import read

Form = Literal["html", "mp4"]
"""A page that plays in 3D with no network, or a video."""
SIZE = (1280, 720)
"""Width and height of a video, unless others are asked for."""


@dataclass(frozen=True)
class Film:
    """A film that is kept."""

    name: str
    bytes: int
    created_at: float
    """Seconds since the epoch."""


class Films:
    """`studio.films`."""

    def __init__(self, connection: Connection) -> None:
        self._connection = connection

    def __iter__(self) -> Iterator[Film]:
        """The films kept, by name."""
        return (read(Film, told) for told in self._connection.pages("/films"))

    def of_take(
        self,
        take: int,
        form: Form = "html",
        *,
        size: tuple[int, int] = SIZE,
        camera: str | None = None,
    ) -> Job:
        """Make a take into a film; a job whose result names it as `film`.

        Raises ConflictError where nothing was recorded, and where videos cannot be written.
        """
        return self._make(f"/takes/{take}/film", form, size, camera=camera)

    def of_stage(self, stage: str, form: Form = "html", *, size: tuple[int, int] = SIZE) -> Job:
        """The same of what happened on a stage, or of the take that is looked at there."""
        return self._make(f"/stages/{stage}/film", form, size)

    def download(self, name: str, folder: str | Path) -> Path:
        """Keep a film in `folder`, under its name; where it is. Raises NotFoundError."""
        path = Path(folder) / name
        path.write_bytes(self._connection.send("GET", f"/films/{name}").content)
        return path

    def delete(self, name: str) -> None:
        """Delete a film; what it shows stays."""
        self._connection.delete(f"/films/{name}")

    def _make(self, path: str, form: Form, size: tuple[int, int], **more: Any) -> Job:
        body = {"form": form, "width": size[0], "height": size[1], **more}
        return read(Job, self._connection.post(path, body))
