"""Two animators at two browsers, each at a stage of their own: no key crosses.

`make soak ONLY=animators` does the same for five minutes.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from benchmarks.soak.animators import kept, together

if TYPE_CHECKING:
    from conftest import Running

SECONDS = 20.0


def test_the_keys_of_two_animators_never_cross(run_studio: Callable[[], Running]) -> None:
    studio = run_studio()
    animators = together(studio.url, SECONDS, seed=3)
    assert animators[0].session != animators[1].session
    assert len(studio.context.stages.all()) == 2
    for animator, found in zip(animators, kept(studio.workspace, animators), strict=True):
        assert animator.thrown == []
        assert found.pairs > 0
        assert found.turned > 0
        assert found.crossed == 0
