"""Friction of continuous contact: forces of a slip velocity, with and without states of their own.

To add a law: a frozen dataclass that gives its row (:mod:`lcpflex.force_laws.layout`), and its case in :mod:`.kernels`.
"""
