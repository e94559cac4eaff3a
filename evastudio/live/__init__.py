"""Stages, inputs and jobs: what runs against a clock, with or without a screen."""
