"""Bodies of space."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
from scipy.sparse import save_npz

import lcpflex as lf
from tests import libs
from tests.property.fuzz.face import Face
from tests.solids import block

__all__ = ["spatial_bodies_faces"]

BEAM: dict[str, Any] = {
    "length": 0.7,
    "area": 1e-4,
    "second_moments": (1e-9, 2e-9),
    "torsion_constant": 2e-9,
    "density": 7850.0,
    "youngs_modulus": 2.1e11,
    "poissons_ratio": 0.3,
    "elements": 4,
}
MATERIAL = {"density": 7800.0, "youngs_modulus": 2e11, "poissons_ratio": 0.3}
CORNERS = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)]
FACES = [(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)]


def _written() -> dict[str, Any]:
    """A body with one mode."""
    products = np.zeros((1, 1, 9))
    products[0, 0, 0] = 1.0
    return {
        "mass": 1.0,
        "inertia": np.diag([0.2, 0.3, 0.4]),
        "stiffness": [100.0],
        "products": products,
        "points": {"a": lf.SpatialPoint(np.zeros(3), np.ones((1, 3)), np.zeros((1, 3)))},
    }


@cache
def _solid() -> dict[str, Any]:
    """One trilinear element."""
    return block((0.3, 0.2, 0.1), (1, 1, 1), "hex1")


def _files() -> dict[str, Any]:
    """The same in files."""
    for name in ("mass", "stiffness"):
        save_npz(f"{name}.npz", _solid()[name])
    return {"mass": "mass.npz", "stiffness": "stiffness.npz", "coordinates": _solid()["coordinates"]}


def _meshed() -> dict[str, Any]:
    """Two hexahedra."""
    mesh = libs.skfem.MeshHex.init_tensor(*(np.array(line) for line in ([0.0, 0.15, 0.3], [0.0, 0.2], [0.0, 0.1])))
    return {"mesh": mesh, **MATERIAL}


@cache
def _flexible() -> lf.SpatialBody:
    return lf.SpatialMatrices(**_solid()).reduce(2)


def spatial_bodies_faces() -> list[Face]:
    def named(name: str, **arguments: Any) -> Face:
        return Face(name, getattr(lf, name), lambda: dict(arguments))

    return [
        named("SpatialRigidBody", mass=1.0, inertia=(0.2, 0.3, 0.4), center=(0, 0, 0), points={"a": (0.1, 0, 0)}),
        named("Sphere", radius=0.1, mass=1.0),
        Face("Sphere of density", lf.Sphere, lambda: {"radius": 0.1, "density": 7800.0}),
        named("Cuboid", a=0.1, b=0.2, c=0.3, mass=1.0),
        named("Cylinder", radius=0.1, length=0.3, mass=1.0),
        named("Capsule", radius=0.1, length=0.3, mass=1.0),
        named("ConvexHull", points=CORNERS, mass=1.0),
        named("Polyhedron", surface=(CORNERS, FACES), mass=1.0, length_unit="m"),
        Face("SpatialBody", lf.SpatialBody, _written),
        Face(
            "SpatialBody.point",
            lf.SpatialBody.point,
            lambda: {"name": "center"},
            lambda: lf.Sphere(0.1, mass=1.0),
        ),
        Face("SpatialBody.at_nodes", lf.SpatialBody.at_nodes, lambda: {"nodes": [0, 1, 2]}, _flexible),
        Face(
            "SpatialBody.face",
            lf.SpatialBody.face,
            lambda: {"name": "surface"},
            lambda: lf.Solid(**_meshed()).reduce(0),
        ),
        named("SpatialBeam", **BEAM),
        Face("SpatialBeam.reduce", lf.SpatialBeam.reduce, lambda: {"modes": 2}, lambda: lf.SpatialBeam(**BEAM)),
        Face(
            "SpatialBeam.reduce stiffened",
            lf.SpatialBeam.reduce,
            lambda: {"modes": 2, "stiffening": lf.Stiffening(axial_force=1.0)},
            lambda: lf.SpatialBeam(**BEAM),
        ),
        Face("SpatialMatrices", lf.SpatialMatrices, lambda: dict(_solid())),
        Face("matrices_from_files in space", lf.matrices_from_files, _files),
        Face(
            "SpatialMatrices.reduce",
            lf.SpatialMatrices.reduce,
            lambda: {"modes": 2},
            lambda: lf.SpatialMatrices(**_solid()),
        ),
        Face("Solid", lf.Solid, _meshed),
        Face("Solid.box", lf.Solid.box, lambda: {"sizes": (0.3, 0.2, 0.1), "elements": (2, 1, 1), **MATERIAL}),
        Face("Solid.bar", lf.Solid.bar, lambda: {"length": 0.3, "height": 0.2, "width": 0.1, "size": 0.2, **MATERIAL}),
        Face("Solid.cylinder", lf.Solid.cylinder, lambda: {"radius": 0.1, "length": 0.3, "size": 0.2, **MATERIAL}),
        Face("Solid.tube", lf.Solid.tube, lambda: {"inner": 0.1, "outer": 0.2, "length": 0.3, "size": 0.2, **MATERIAL}),
        Face("Solid.ball", lf.Solid.ball, lambda: {"radius": 0.1, "size": 0.2, **MATERIAL}),
        Face("Solid.reduce", lf.Solid.reduce, lambda: {"modes": 2}, lambda: lf.Solid(**_meshed())),
    ]
