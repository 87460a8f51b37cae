"""Explicit solutions: critical regions, search trees, clip forms."""
