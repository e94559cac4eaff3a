"""The HTTP face: routes, access, limits."""
