"""A beam and a plate of aluminium that tests of compilation have reduced."""

from __future__ import annotations

import lcpflex as lf

__all__ = ["BEAM", "E", "PLATE", "RHO"]

E, RHO = 7e10, 2700.0
BEAM = lf.Beam(1.0, 0.02, 0.005, RHO, E)
PLATE = lf.Continuum(
    lf.meshes.quadratic(lf.meshes.bar(0.3, 0.02, 15)),
    density=RHO,
    youngs_modulus=E,
    poissons_ratio=0.33,
    thickness=0.02,
)
