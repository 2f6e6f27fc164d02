"""The unit of length of a mesh that comes from elsewhere, and meshes whose numbers can hardly be metres."""

from __future__ import annotations

import math
import os
import warnings
from typing import Any

import numpy as np

from lcpflex.basics.arguments import one_of, positive
from lcpflex.bodies.fem.facets import outer_facets
from lcpflex.bodies.fem.material import SPEEDS
from lcpflex.bodies.fem.mesh import Mesh
from lcpflex.errors import ModelWarning

__all__ = ["METRES", "check_rigid_size", "check_size", "metres"]

METRES = {"m": 1.0, "cm": 1e-2, "mm": 1e-3, "um": 1e-6, "in": 0.0254, "ft": 0.3048}
METAL = 65e9, 2600.0  # [Pa], [kg/m^3] from which a solid is metal or glass: aluminium 70e9 and 2700, concrete 30e9
POLYMER = 6e9, (850.0, 1600.0)  # [Pa], [kg/m^3]: rubber and plastics; wood and ice are stiffer, soils heavier
THICKEST, WIDEST = 6.0, 60.0  # [m] of solid metal (forgings and press frames have 3 to 5), of anything (dams have 30)
HEAVIEST = 1e6  # [kg] of one piece of metal: the largest ingots have 600 t
DRAWN = 20.0  # [m] of metal or plastic whose mesh comes from a file: programs that draw such write millimetres
SOLID, LIGHTEST = 850.0, 0.1  # [kg/m^3] from which a body is no foam or shell, below which it is nothing: air has 1.2
FREE_BEAM = 4.73**2 / (2.0 * math.pi * math.sqrt(12.0))  # f L^2 / (c h) of the first bending of a free rectangular bar


def metres(unit: Any) -> float:
    """How many metres a unit of length has: "m", "cm", "mm", "um", "in", "ft", or a number > 0; None is a metre.

    Raises ModelError for anything else.
    """
    if unit is None:
        return 1.0
    if isinstance(unit, str):
        return METRES[one_of("length_unit", unit, METRES)]
    return positive("length_unit", unit)


def check_size(part: Any, mesh: Mesh) -> None:
    """Warn of a body that is larger than solids of its material are, unless it has a ``length_unit``.

    Its mesh is in another unit, most likely. The mean width 2 A / P, A the area of the mesh and P the length of its
    boundary, in space 3 V / A, lets slender and hollow bodies be as long as they like; a mesh from a file is suspected
    sooner.

    part: a body of the mesh. mesh: checked, in metres.
    """
    if part.length_unit is not None:
        return
    E, density = part.youngs_modulus, part.density
    if math.sqrt(E / density) > SPEEDS[1]:  # the material is not in SI, which is told
        return
    (content, width), extent = (_area_and_width if mesh.kind.dimension == 2 else _volume_and_width)(mesh), mesh.size
    metal = METAL[0] <= E and METAL[1] <= density
    polymer = POLYMER[0] >= E and POLYMER[1][0] <= density <= POLYMER[1][1]
    drawn = isinstance(part.mesh, (str, os.PathLike)) and (metal or polymer) and extent > DRAWN
    thickness = getattr(part, "thickness", 0.0) if mesh.kind.dimension == 2 else 1.0
    heavy = metal and density * content * thickness > HEAVIEST
    if not (drawn or heavy or width > (THICKEST if metal else WIDEST)):
        return
    speed = math.sqrt(E / density)
    first = min(FREE_BEAM * speed * width / extent**2, speed / (2.0 * extent))
    warnings.warn(
        f"{mesh.source}: {extent:.4g} m long and {width:.3g} m wide in the mean, it has a first frequency of about "
        f"{first:.2g} Hz in its material, with waves of {speed:.4g} m/s, and is larger than solids of it are: are its "
        f"places in mm? length_unit='mm' makes it {1e-3 * extent:.4g} m long, with {1e3 * first:.2g} Hz; "
        "length_unit='m' says that it is meant",
        ModelWarning,
        stacklevel=4,
    )


def check_rigid_size(source: str, extent: float, width: float, density: float, *, from_file: bool) -> None:
    """Warn of a rigid body that is larger than solids of its density are, or too large for its mass.

    For bodies without a ``length_unit``. Boulders may be as large as they like, up to DRAWN from a file.

    Parameters
    ----------
    source : what the body is called in messages
    extent : [m]
    width : mean width 3 V / A, which lets slender and hollow bodies be as long as they like [m]
    density : mass over volume [kg/m^3]
    """
    large = width > WIDEST or (from_file and density >= SOLID and extent > DRAWN)
    light = from_file and density < LIGHTEST
    if not (large or light):
        return
    what = "larger than solids of it are" if large else "too large for its mass"
    warnings.warn(
        f"{source}: {extent:.4g} m long and {width:.3g} m wide in the mean, with a density of {density:.4g} kg/m^3, it "
        f"is {what}: are its places in mm? length_unit='mm' makes it {1e-3 * extent:.4g} m long; length_unit='m' says "
        "that it is meant",
        ModelWarning,
        stacklevel=3,
    )


def _area_and_width(mesh: Mesh) -> tuple[float, float]:
    """A [m^2] and 2 A / P [m] of the corners of the elements."""
    corners = mesh.places[mesh.cells[:, : mesh.kind.corners]]
    arms = corners - corners[:, :1]
    on = np.roll(arms, -1, axis=1)
    area = 0.5 * float((arms[..., 0] * on[..., 1] - on[..., 0] * arms[..., 1]).sum())
    edges = np.roll(corners, -1, axis=1) - corners
    lengths = np.hypot(edges[..., 0], edges[..., 1]).ravel()
    _, first, count = np.unique(mesh.edge_keys(), return_index=True, return_counts=True)
    around = float(lengths[first[count == 1]].sum())
    return area, 2.0 * area / around if around > 0.0 else 0.0  # elements that overlap, which others refuse


def _volume_and_width(mesh: Mesh) -> tuple[float, float]:
    """V [m^3] and 3 V / A [m] of the corners of the elements, by the triangles of their boundary."""
    at = mesh.places[outer_facets(mesh)[:, : mesh.kind.facet_corners]]
    arms = at - at.mean(axis=(0, 1))
    volume, area = 0.0, 0.0
    for k in range(1, mesh.kind.facet_corners - 1):
        a, b, c = arms[:, 0], arms[:, k], arms[:, k + 1]
        volume += float(np.einsum("ti,ti->", a, np.cross(b, c))) / 6.0
        area += 0.5 * float(np.linalg.norm(np.cross(b - a, c - a), axis=1).sum())
    return volume, 3.0 * volume / area
