"""The shelf: the policies and switches of a workspace as a program takes them, puts and asks them.

What was loaded stays at hand as long as its file stays the same.
"""

from __future__ import annotations

import hashlib
import threading
from collections import OrderedDict
from pathlib import Path

from evastudio.errors import ConflictError, InvalidInputError, NotFoundError, StorageError
from evastudio.learning.catalog import checked_policy_name, list_policies, policy_file_called
from evastudio.learning.policy import Policy
from evastudio.learning.policy_files import SUFFIX, load_policy, parse_policy
from evastudio.learning.switch import SUFFIX as SWITCH
from evastudio.learning.switch import parse_switch
from evastudio.workspace import Workspace
from evastudio.writing import write_whole

KEPT = 8
"""Policies that are kept loaded."""

Identity = tuple[str, int, int, int]


class Shelf:
    """The policies of a workspace. Safe to use from several threads."""

    def __init__(self, workspace: Workspace) -> None:
        self._workspace = workspace
        self._lock = threading.Lock()
        self._writing = threading.Lock()
        self._loaded: OrderedDict[Identity, Policy] = OrderedDict()
        self._digests: dict[Identity, str] = {}

    def file(self, name: str) -> Path:
        """The file of a policy or switch. Raises NotFoundError."""
        return policy_file_called(name, self._workspace.policy_folders)

    def digest(self, name: str) -> str:
        """SHA-256 of its file, hexadecimal. Raises NotFoundError."""
        path = self.file(name)
        identity = _identity(path)
        with self._lock:
            known = self._digests.get(identity)
        if known is None:
            known = hashlib.sha256(path.read_bytes()).hexdigest()
            with self._lock:
                if len(self._digests) > 1000:
                    self._digests.clear()
                self._digests[identity] = known
        return known

    def policy(self, name: str) -> Policy:
        """A policy, loaded once. Raises NotFoundError, ConflictError for a switch, StorageError."""
        path = self.file(name)
        if path.name.endswith(SWITCH):
            raise ConflictError(
                f"{name!r} is a switch: it decides by what it has seen before, so it is asked in "
                "a world. Ask one of the policies it switches between."
            )
        identity = _identity(path)
        with self._lock:
            found = self._loaded.get(identity)
            if found is not None:
                self._loaded.move_to_end(identity)
                return found
        found = load_policy(path)
        with self._lock:
            self._loaded[identity] = found
            while len(self._loaded) > KEPT:
                self._loaded.popitem(last=False)
        return found

    def put(self, name: str, data: bytes, *, switch: bool, replaces: str | None = None) -> None:
        """Keep the bytes of a policy file, or of a `switch`, as `name` of the workspace.

        They are read as any such file and never executed. `replaces` is the digest of the file
        that may be replaced. Raises InvalidInputError for what is no policy, ConflictError where
        there is one of that name and it is not the one to replace.
        """
        checked_policy_name(name)
        parse = parse_switch if switch else parse_policy
        try:
            parse(data, "What was sent")
        except StorageError as error:
            raise InvalidInputError(str(error)) from None
        with self._writing:
            try:
                before = self.digest(name)
            except NotFoundError:
                before = None
            if before != replaces:
                there = "There is no" if before is None else "There is already a"
                raise ConflictError(
                    f"{there} policy {name!r}; to replace one, say which by its ETag in If-Match, "
                    "or choose another name."
                )
            suffix = SWITCH if switch else SUFFIX
            if before is not None and not self.file(name).name.endswith(suffix):
                raise ConflictError(
                    f"{name!r} is a {'policy' if switch else 'switch'}, and what was sent is not. "
                    "Delete it first, or choose another name."
                )
            write_whole(self._workspace.policies / (name + suffix), data)

    def remove(self, name: str) -> None:
        """Delete a policy or switch of the workspace for good.

        Raises ConflictError for a shipped one, and where a switch needs it.
        """
        with self._writing:
            path = self.file(name)
            if path.parent.resolve() != self._workspace.policies.resolve():
                raise ConflictError(f"{name!r} is shipped with the studio and stays.")
            entries = list_policies(self._workspace.policy_folders).values()
            needing = [
                entry.name
                for entry in entries
                if entry.switch is not None
                and entry.name != name
                and name in {policy.rpartition(":")[2] for policy in entry.switch.policies}
            ]
            if needing:
                raise ConflictError(
                    f"{name!r} is needed by the switch {' and by '.join(map(repr, needing))}; "
                    "delete that first."
                )
            try:
                path.unlink()
            except OSError as error:
                raise StorageError(f"{name!r} could not be deleted: {error.strerror}.") from None


def _identity(path: Path) -> Identity:
    try:
        found = path.stat()
    except OSError as error:
        raise StorageError(f"{path.name!r} cannot be read: {error.strerror}.") from None
    return str(path), found.st_mtime_ns, found.st_size, found.st_ino
