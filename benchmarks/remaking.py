"""Shipped policies, made again by the commands that they carry.

Nothing here is run by itself: the tests do it for those that a scripted demonstrator taught,
`street.py` for those that were learned from recordings.
"""

from __future__ import annotations

import shlex
import subprocess
import sys
from pathlib import Path

import numpy as np

from evastudio.learning.policy_files import load_policy


def apart(path: Path, folder: Path) -> float:
    """How far the policy of `path` is from what its own commands make in `folder`.

    Mean difference of the actions at 500 states drawn at random, as a share of their range. Not
    zero: sines differ in the last place from one kind of processor to another. Infinite where
    they learned from different numbers of pairs.
    """
    policy = load_policy(path)
    for command in policy.made_by.split(" && "):
        program, *words = shlex.split(command)
        if program != "evastudio":
            raise SystemExit(f"{path.name} was made by {command!r}; expected evastudio.")
        subprocess.run(
            [sys.executable, "-m", "evastudio", *words, "--workspace", "."],
            check=True,
            cwd=folder,
            capture_output=True,
        )
    again = load_policy(folder / path.name)
    if policy.pairs != again.pairs:
        return float("inf")
    states = np.random.default_rng(0).normal(size=(500, policy.state.size))
    span = policy.action.high - policy.action.low
    return float((np.abs(policy.act_states(states) - again.act_states(states)) / span).mean())
