"""Bodies of arrays for generated requests: whole ones, odd ones, and damaged ones."""

from __future__ import annotations

import io

import numpy as np
import schemathesis
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

NAMES = ("states", "actions", "first_step", "seeds", "steps", "about", "moving.position", "x")
TYPES = ("float64", "float32", "int64", "uint8", "bool")


def packed(content: dict[str, np.ndarray]) -> bytes:
    file = io.BytesIO()
    np.savez(file, **content)
    return file.getvalue()


array = st.sampled_from(TYPES).flatmap(
    lambda kind: arrays.arrays(kind, arrays.array_shapes(min_dims=0, max_dims=3, max_side=7))
)
whole = st.dictionaries(st.sampled_from(NAMES), array, max_size=4).map(packed)
damaged = st.tuples(whole, st.integers(0, 300)).map(lambda given: given[0][: -given[1] or None])
schemathesis.openapi.media_type("application/x-npz", st.one_of(whole, damaged, st.binary()))
