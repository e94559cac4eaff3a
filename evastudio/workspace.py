"""A workspace: a user's folder with their scenes, policies, clips and session store."""

from __future__ import annotations

import os
import tempfile
from dataclasses import dataclass, field
from pathlib import Path

from evastudio.errors import StorageError


def shipped() -> Path:
    """The folder that holds the shipped `scenes/`, `policies/` and `web/`.

    In a checkout that is the checkout itself, in an installed package a folder inside it.
    """
    package = Path(__file__).parent
    inside = package / "_shipped"
    return inside if inside.is_dir() else package.parent


@dataclass(frozen=True)
class Workspace:
    """Where a user's things are. Reading needs nothing; `ready` makes it writable."""

    root: Path
    """Its folder; a string that names one will do."""
    store: str | None = field(default=None, repr=False)
    """URL of the session store, with its password if it has one; `studio.db` in `root` when
    None."""
    paths: bool = True
    """Whether a policy may be named by the path of its file, too. A server's may not: who talks to
    it from afar, or sends it a switch, would read any file of this machine."""

    def __post_init__(self) -> None:
        object.__setattr__(self, "root", Path(self.root))

    @property
    def store_url(self) -> str:
        return self.store or f"sqlite:///{self.root.resolve() / 'studio.db'}"

    @property
    def scene_folders(self) -> tuple[Path, ...]:
        """The user's first: a scene of the same name hides the shipped one."""
        return _distinct(self.root / "scenes", shipped() / "scenes")

    @property
    def policy_folders(self) -> tuple[Path, ...]:
        return _distinct(self.root / "policies", shipped() / "policies")

    @property
    def policies(self) -> Path:
        """Where new policies are written."""
        return self.root / "policies"

    @property
    def motion(self) -> Path:
        """Where a user's clips lie, .glb and .bvh, and which activity each is for."""
        return self.root / "motion"

    @property
    def pictures(self) -> Path:
        """Where pictures of evaluations are kept once they are drawn; they can be drawn again."""
        return self.root / "pictures"

    @property
    def conflicts(self) -> Path:
        """Where it is kept what a look for conflicts found; looking again makes it anew."""
        return self.root / "conflicts"

    @property
    def films(self) -> Path:
        """Where films of runs and takes are kept, to be handed on."""
        return self.root / "films"

    @property
    def unsaved(self) -> tuple[Path, ...]:
        """Where takes wait that cannot be saved: here, or elsewhere where this disk is full."""
        cache = Path(os.environ.get("XDG_CACHE_HOME") or Path("~/.cache").expanduser())
        temporary = Path(tempfile.gettempdir()) / f"evastudio-{os.getuid()}"
        own = not temporary.exists() or temporary.lstat().st_uid == os.getuid()
        folders = (self.root / "unsaved", cache / "evastudio" / "unsaved", temporary)
        return folders if own else folders[:2]

    def ready(self) -> Workspace:
        """Make the folder and check that it can be written. Raises StorageError."""
        problem = None
        try:
            self.policies.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            problem = error.strerror or str(error)
        if problem is None and not os.access(self.root, os.W_OK):
            problem = "permission denied"
        if problem is not None:
            raise StorageError(
                f"The workspace {str(self.root)!r} cannot be written ({problem}). Choose another "
                "folder with --workspace, or change its permissions."
            )
        return self


def _distinct(*folders: Path) -> tuple[Path, ...]:
    return tuple({folder.resolve(): folder for folder in folders}.values())
