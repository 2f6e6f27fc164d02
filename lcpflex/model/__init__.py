"""The compiled form of a scene: read-only arrays that all kernels share.

To add an array of a scene: a field in :mod:`lcpflex.model.arrays`, and the place in :mod:`lcpflex.compile` that fills
it.
"""
