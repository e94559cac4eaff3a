"""Pilots on offer: whatever lies among the policies, the others are listed."""

from __future__ import annotations

import json
from collections.abc import Callable

import numpy as np
import pytest
from safetensors.numpy import save

from evastudio.learning.policy_files import FORMAT, KEY
from evastudio.live.piloting import pilots_for
from evastudio.workspace import Workspace
from evastudio.world.scene import Scene


@pytest.mark.parametrize("scene", [[], ["asteroids"], "asteroids", 3, None, {}])
def test_a_file_that_says_no_scene_is_not_on_offer(
    workspace: Workspace, asteroids: Callable[..., Scene], scene: object
) -> None:
    header = json.dumps({"format": FORMAT, "scene": scene})
    odd = save({"a": np.zeros(1)}, metadata={KEY: header})
    (workspace.policies / "odd.safetensors").write_bytes(odd)
    names = [entry.name for entry in pilots_for(workspace, asteroids())]
    assert "asteroids-careful" in names
    assert "odd" not in names
