"""Bodies: where they come from (mass properties, shapes, finite elements) and the one form they all take."""

from __future__ import annotations

from typing import TYPE_CHECKING

from lcpflex.basics.lazy import attach

if TYPE_CHECKING:
    from lcpflex.bodies.bar import Bar
    from lcpflex.bodies.beam import Beam
    from lcpflex.bodies.body import Body, Chain, FidelityLevel, MaterialPoint, Resolution, Round, Shortening
    from lcpflex.bodies.continuum import Continuum
    from lcpflex.bodies.matrices import Matrices
    from lcpflex.bodies.reduction.component_modes import (
        craig_bampton,
        free_interface,
        residual_compliance,
        sub_regional,
        unreduced,
    )
    from lcpflex.bodies.reduction.damping import Rayleigh
    from lcpflex.bodies.reduction.interface import Interface
    from lcpflex.bodies.reduction.stiffening import Stiffening
    from lcpflex.bodies.rigid import Box, Disc, Polygon, RigidBody
    from lcpflex.bodies.solid_of_revolution import SolidOfRevolution

__all__ = [
    "Bar",
    "Beam",
    "Body",
    "Box",
    "Chain",
    "Continuum",
    "Disc",
    "Interface",
    "MaterialPoint",
    "Matrices",
    "Polygon",
    "Rayleigh",
    "Resolution",
    "RigidBody",
    "Round",
    "FidelityLevel",
    "Shortening",
    "SolidOfRevolution",
    "Stiffening",
    "craig_bampton",
    "free_interface",
    "residual_compliance",
    "sub_regional",
    "unreduced",
]

__getattr__, __dir__ = attach(__name__, renamed={"Rung": "FidelityLevel"})
