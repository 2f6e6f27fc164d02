"""Elastic contact laws: force, stiffness and energy of an indentation.

To add a law: a frozen dataclass that gives its row (:mod:`lcpflex.force_laws.layout`), and its case in :mod:`.kernels`.
"""
