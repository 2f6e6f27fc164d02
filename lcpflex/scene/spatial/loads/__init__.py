"""Loads that there are in space only; those of both are in :mod:`lcpflex.scene.loads`."""
