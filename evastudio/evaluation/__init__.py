"""The same seeded worlds for everyone, and what came of them."""
