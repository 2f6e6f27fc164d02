"""Joints that there are in space only; those of both are in :mod:`lcpflex.scene.joints`. A joint is a file here.

An axis is fixed in the material at Q, in the axes of the body of Q (world axes on the ground), its partner at P in
those of the body of P: what coincides with it at the start if omitted.
"""
