"""A beam and a plate of aluminium that tests of compilation have reduced."""

from __future__ import annotations

from functools import cache

import lcpflex as lf

__all__ = ["BEAM", "E", "RHO", "plate"]

E, RHO = 7e10, 2700.0
BEAM = lf.Beam(1.0, 0.02, 0.005, RHO, E)


@cache
def plate() -> lf.Continuum:
    return lf.Continuum(
        lf.meshes.quadratic(lf.meshes.bar(0.3, 0.02, 15)),
        density=RHO,
        youngs_modulus=E,
        poissons_ratio=0.33,
        thickness=0.02,
    )
