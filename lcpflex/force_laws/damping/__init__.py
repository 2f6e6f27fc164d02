"""What contact laws dissipate in the normal direction, and the restitution that comes of it.

To add a law: a frozen dataclass that gives its row (:mod:`lcpflex.force_laws.layout`), and its case in :mod:`.kernels`.
"""
