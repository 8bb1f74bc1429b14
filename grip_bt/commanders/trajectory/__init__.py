"""Timing of paths."""
