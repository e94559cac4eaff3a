"""Anything that chooses actions."""
