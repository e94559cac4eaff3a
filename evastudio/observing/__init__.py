"""Seeing inside a running studio: its health, its metrics, its requests."""
