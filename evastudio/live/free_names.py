"""Names for what is made without a name: nothing that is another is replaced."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterable
from dataclasses import replace
from pathlib import Path

from evastudio.errors import StorageError
from evastudio.learning.policy import Policy
from evastudio.learning.policy_files import SUFFIX, load_policy, policy_bytes
from evastudio.learning.switch import SUFFIX as SWITCH

LONGEST = 80


def free_file(path: Path, called: Callable[[Path], Policy], folders: Iterable[Path]) -> Path:
    """`path`, or the first of path-2, path-3, ... that nothing else in `folders` has taken.

    `called` tells the policy as it would be written to a file; one that holds just that, whatever
    its date, may be replaced by it.
    """
    stem, folders = path.name.removesuffix(SUFFIX), tuple(folders)
    for number in itertools.count(1):
        end = "" if number == 1 else f"-{number}"
        name = stem[: LONGEST - len(end)] + end
        candidate = path.with_name(name + SUFFIX)
        files = [at / (name + suffix) for at in folders for suffix in (SUFFIX, SWITCH)]
        taken = any(file.exists() for file in files)
        if not taken or _same(candidate, called(candidate)):
            return candidate
    raise AssertionError


def _same(path: Path, policy: Policy) -> bool:
    try:
        created = load_policy(path).created
        return path.read_bytes() == policy_bytes(replace(policy, created=created))
    except (StorageError, OSError):
        return False
