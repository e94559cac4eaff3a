"""The scene contract, batched worlds, scene loading and checking."""
