"""What must be fast, compiled by numba: loaded when first needed."""
