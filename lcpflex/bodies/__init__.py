"""Bodies: where they come from (mass properties, shapes, finite elements) and the one form they all take."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

_HOME = {
    "Bar": "lcpflex.bodies.bar",
    "Beam": "lcpflex.bodies.beam",
    "Body": "lcpflex.bodies.body",
    "Box": "lcpflex.bodies.rigid",
    "Chain": "lcpflex.bodies.body",
    "Continuum": "lcpflex.bodies.continuum",
    "Disc": "lcpflex.bodies.rigid",
    "MaterialPoint": "lcpflex.bodies.body",
    "Interface": "lcpflex.bodies.reduction.interface",
    "Matrices": "lcpflex.bodies.matrices",
    "Polygon": "lcpflex.bodies.rigid",
    "Rayleigh": "lcpflex.bodies.reduction.damping",
    "Resolution": "lcpflex.bodies.body",
    "RigidBody": "lcpflex.bodies.rigid",
    "Round": "lcpflex.bodies.body",
    "Rung": "lcpflex.bodies.body",
    "Shortening": "lcpflex.bodies.body",
    "SolidOfRevolution": "lcpflex.bodies.solid_of_revolution",
    "Stiffening": "lcpflex.bodies.reduction.stiffening",
    "craig_bampton": "lcpflex.bodies.reduction.component_modes",
    "free_interface": "lcpflex.bodies.reduction.component_modes",
    "residual_compliance": "lcpflex.bodies.reduction.component_modes",
    "sub_regional": "lcpflex.bodies.reduction.component_modes",
    "unreduced": "lcpflex.bodies.reduction.component_modes",
}

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
    "Rung",
    "Shortening",
    "SolidOfRevolution",
    "Stiffening",
    "craig_bampton",
    "free_interface",
    "residual_compliance",
    "sub_regional",
    "unreduced",
]


def __getattr__(name: str) -> Any:
    """Load a public name from its module at first use."""
    if name not in _HOME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value = getattr(import_module(_HOME[name]), name)
    globals()[name] = value
    return value


if TYPE_CHECKING:
    from lcpflex.bodies.bar import Bar
    from lcpflex.bodies.beam import Beam
    from lcpflex.bodies.body import Body, Chain, MaterialPoint, Resolution, Round, Rung, Shortening
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
