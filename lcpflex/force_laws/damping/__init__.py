"""What contact laws dissipate in the normal direction, and the restitution that comes of it.

To add a law: its class, a frozen dataclass with the name of its kind, beside the others, and that name and its branch
in :mod:`.kernels`.
"""
