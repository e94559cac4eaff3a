"""Going over from one thing to another without a kink."""

from __future__ import annotations

import numpy as np

from evastudio.motion.rotations import Numbers


def smooth(share: Numbers) -> Numbers:
    """0 below 0, 1 above 1, and without a kink between."""
    inside = np.clip(share, 0.0, 1.0)
    return np.asarray(inside * inside * (3 - 2 * inside))


def moving(speeds: Numbers, turn_rates: Numbers | float) -> Numbers:
    """How far steps have taken over from standing, 0 to 1."""
    return smooth(np.hypot(speeds / 0.2, np.asarray(turn_rates) / 0.4))
