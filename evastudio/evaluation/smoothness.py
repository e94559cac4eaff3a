"""How smoothly something moves: two measures of the field, for any path or pace.

Both are dimensionless and grow towards zero with smoothness: a path of one graceful stroke is
near zero, one of many small corrections far below it. S. Balasubramanian, A. Melendez-Calderon,
A. Roby-Brami, E. Burdet, "On the analysis of movement smoothness", J. NeuroEng. Rehab. 12:112,
2015.
"""

from __future__ import annotations

import numpy as np

from evastudio.world.spaces import Array

SPECTRUM_HZ = 10.0
"""Faster components are noise, and not looked at."""
FAINTEST = 0.05
"""Components at the top of the spectrum weaker than this share of the strongest are not either."""
ROUNDING = 1e-9
"""A jerk below this is that of the last digits of a steady flight: one smooth stroke has 205."""
PADDING = 4
"""The spectrum is computed on 2 to this power times as many moments as there are."""


def log_dimensionless_jerk(velocities: Array, dt_s: float) -> float:
    """Minus the logarithm of the mean squared jerk, made dimensionless by duration and top speed.

    velocities: shape (moments, d), m/s, every `dt_s`. The source's equation 9, LDLJ-V. NaN for
    fewer than 4 moments and for what never moves; infinite for what never changes its velocity.
    """
    if len(velocities) < 4:
        return float("nan")
    speeds = np.sqrt((velocities**2).sum(axis=1))
    peak = float(speeds.max())
    if peak == 0.0:
        return float("nan")
    jerk = np.diff(velocities, n=2, axis=0) / dt_s**2
    duration = (len(velocities) - 1) * dt_s
    whole = float((jerk**2).sum()) * dt_s * duration**3 / peak**2
    return float("inf") if whole < ROUNDING else float(-np.log(whole))


def spectral_arc_length(profile: Array, dt_s: float) -> float:
    """Minus the length of the curve that the profile's amplitude spectrum draws.

    profile: shape (moments,), a speed (of moving or of turning) every `dt_s`. The source's
    equation 10, SPARC, with its constants. NaN for fewer than 4 moments and for a profile that is
    zero throughout.
    """
    if len(profile) < 4 or not np.any(profile):
        return float("nan")
    count = int(2 ** (np.ceil(np.log2(len(profile))) + PADDING))
    frequencies = np.fft.rfftfreq(count, dt_s)
    amplitudes = np.abs(np.fft.rfft(profile, count))
    amplitudes /= amplitudes.max()
    seen = frequencies <= SPECTRUM_HZ
    frequencies, amplitudes = frequencies[seen], amplitudes[seen]
    last = int(np.nonzero(amplitudes >= FAINTEST)[0][-1])
    frequencies, amplitudes = frequencies[: last + 1], amplitudes[: last + 1]
    if len(frequencies) < 2:
        return 0.0
    across = np.diff(frequencies) / (frequencies[-1] - frequencies[0])
    return float(-np.sqrt(across**2 + np.diff(amplitudes) ** 2).sum())
