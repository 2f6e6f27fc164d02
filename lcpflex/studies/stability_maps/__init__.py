"""Stability maps: where in a plane of parameters methods hold, and where they fail."""
