"""Inertia, forces and constraints of spatial bodies."""
