"""Friction of continuous contact: forces of a slip velocity, with and without states of their own.

To add a law: its class, a frozen dataclass with the name of its kind, beside the others, and that name and its branch
in :mod:`.kernels`.
"""
