"""Elastic contact laws: force, stiffness and energy of an indentation.

To add a law: its class, a frozen dataclass with the name of its kind, beside the others, and that name and its branch
in :mod:`.kernels`.
"""
