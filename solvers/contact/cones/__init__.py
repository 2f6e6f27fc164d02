"""Spatial contact problems: cones instead of intervals."""
