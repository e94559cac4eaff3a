"""Telling what a person does to a view's camera from the echo of what was sent to it."""

from __future__ import annotations

import threading
from collections import deque

import numpy as np

from evastudio.world.bodies import Camera
from evastudio.world.spaces import Array

REMEMBERED = 120
"""Cameras sent last; a browser that draws slowly tells of old ones."""
EXACT = 2e-3
"""A browser tells a camera that was sent to it back to within this share of its distance."""


class Turns:
    """What was sent to the browsers of a view, and what they told of it.

    A browser tells of every change of its camera, whoever made it. One that has not yet told of
    any camera that was sent to it has not drawn the view, and is not believed.
    """

    def __init__(self) -> None:
        self._sent: deque[Camera] = deque(maxlen=REMEMBERED)
        self._drawing: set[int] = set()
        self._lock = threading.Lock()

    def sent(self, camera: Camera) -> None:
        """Every browser was sent there."""
        with self._lock:
            self._sent.append(camera)

    def by_hand(self, client: int, told: Camera) -> Camera | None:
        """The camera that somebody turned to `told`, or None where it is an echo.

        Turning and coming closer leave the point that is looked at where it is, so of those sent
        the one turned is the last that looks nearest to there.
        """
        with self._lock:
            sent = list(self._sent)
            if not sent:
                return None
            reach = EXACT * max(1.0, float(np.linalg.norm(told.look_at - told.position)))
            aims = _distances([one.look_at for one in sent], told.look_at)
            places = _distances([one.position for one in sent], told.position)
            # Place and aim are sent one after the other, and can be told of in between.
            if aims.min() < reach and places.min() < reach:
                self._drawing.add(client)
                return None
            if client not in self._drawing:
                return None
            self._sent.append(told)
            return sent[len(sent) - 1 - int(np.argmin(aims[::-1]))]

    def left(self, client: int) -> None:
        """That browser is gone."""
        with self._lock:
            self._drawing.discard(client)


def _distances(points: list[Array], point: Array) -> Array:
    return np.asarray(np.linalg.norm(np.stack(points) - point, axis=1))
