"""Bodies: where they come from (mass properties, shapes, finite elements) and the one form they all take."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

_HOME = {
    "Bar": "bar",
    "Beam": "beam",
    "Body": "body",
    "Box": "rigid",
    "Chain": "body",
    "Continuum": "continuum",
    "Disc": "rigid",
    "MaterialPoint": "body",
    "Interface": "interface",
    "Matrices": "matrices",
    "Polygon": "rigid",
    "Rayleigh": "reduction",
    "Resolution": "body",
    "RigidBody": "rigid",
    "Round": "body",
    "Rung": "body",
    "Shortening": "body",
    "SolidOfRevolution": "solid_of_revolution",
    "Stiffening": "stiffening",
    "craig_bampton": "reductions",
    "free_interface": "reductions",
    "residual_compliance": "reductions",
    "sub_regional": "reductions",
    "unreduced": "reductions",
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
    value = getattr(import_module(f"{__name__}.{_HOME[name]}"), name)
    globals()[name] = value
    return value


if TYPE_CHECKING:
    from lcpflex.bodies.bar import Bar
    from lcpflex.bodies.beam import Beam
    from lcpflex.bodies.body import Body, Chain, MaterialPoint, Resolution, Round, Rung, Shortening
    from lcpflex.bodies.continuum import Continuum
    from lcpflex.bodies.interface import Interface
    from lcpflex.bodies.matrices import Matrices
    from lcpflex.bodies.reduction import Rayleigh
    from lcpflex.bodies.reductions import craig_bampton, free_interface, residual_compliance, sub_regional, unreduced
    from lcpflex.bodies.rigid import Box, Disc, Polygon, RigidBody
    from lcpflex.bodies.solid_of_revolution import SolidOfRevolution
    from lcpflex.bodies.stiffening import Stiffening
