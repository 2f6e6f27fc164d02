"""Pendulums that strike: meshes with a fine contact region each, to be reduced as one likes."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeAlias

import numpy as np

from lcpflex.basics.arguments import whole_number
from lcpflex.bodies.body import Body
from lcpflex.bodies.continuum import Continuum
from lcpflex.bodies.fem.meshes import grid
from lcpflex.bodies.reduction.component_modes import craig_bampton, sub_regional
from lcpflex.bodies.reduction.damping import Rayleigh
from lcpflex.errors import ModelError, shown
from lcpflex.jit.kernel import FloatArray
from lcpflex.scene.joints.revolute import Revolute
from lcpflex.scene.scene import Scene

__all__ = [
    "pendulum_and_rod",
    "pendulum_on_hemisphere",
    "pendulum_with_hammer",
    "rod_with_crown",
    "strip_with_patch",
]

Reduce: TypeAlias = Callable[[Continuum, list[str]], Body]

GROWTH = 1.35  # of elements from one to the next, away from the contact region
FINE = 3e-4  # elements of the contact region [m]
REACH = 2.4e-3  # half of the contact region [m]
GAP = 1e-6  # at the start [m]
ORDER = 1  # linear elements: forces of contact are smooth from node to node


def rod_with_crown(
    fine: float = FINE,
    coarse: float = 6e-3,
    length: float = 0.6,
    crown: float = 0.3,
    remake: Callable[[Any], Any] | None = None,
) -> Continuum:
    """An aluminium rod of 20 x 20 mm whose left end face is a cylinder of radius ``crown``, touched at (0, 0).

    Elements are ``fine`` [m] in the contact region, the set and surface "tip", grow away from it and are at most
    ``coarse`` long; with 6 mm the bending of the rod is less than 5 % too
    stiff. ``remake`` changes the mesh: ``meshes.quadratic``, or quadrilaterals to triangles.
    """
    half = 0.01
    along = graded(length, fine, 2.0 * fine, coarse)
    across = graded(half, fine, REACH, 2.5e-3)
    mesh: Any = grid(along, np.concatenate([-across[:0:-1], across]), order=ORDER)
    x, y = mesh.p
    bulge = y**2 / (2.0 * crown) * np.maximum(0.0, 1.0 - x / (2.0 * half))
    mesh = type(mesh)(np.array([x + bulge, y]), mesh.t)
    return Continuum(
        mesh if remake is None else remake(mesh),
        density=2700.0,
        youngs_modulus=69e9,
        poissons_ratio=0.33,
        thickness=0.02,
        sets={"tip": lambda x, y: (abs(y) < REACH + 0.1 * fine) & (x < y**2 / (2.0 * crown) + 1e-6)},
    )


def pendulum_with_hammer(
    fine: float = FINE,
    coarse: float = 3.5e-3,
    length: float = 0.4,
    strike: float = 0.36,
    remake: Callable[[Any], Any] | None = None,
    layers: int | None = None,
) -> Continuum:
    """A steel pendulum of 12 x 20 mm, hung at (0, 0), "hinge", whose right face, "face", strikes ``strike`` below.

    Its nodes there lie half an element aside from those of the rod: no node meets a corner between two elements.
    Elements are at most ``coarse`` long; with 3.5 mm its bending is less than 5 % too stiff (with 8.4 mm, 19 %). In the
    direction of the impact they grow from ``fine`` to 2.5 mm, or there are ``layers`` of one depth. "back" is the point
    of the left face right behind the middle of the contact region.
    """
    width = 0.012
    if layers is not None:
        layers = whole_number("layers", layers, 1, 1000)
    up = graded(strike, fine, REACH + fine, coarse)
    down = graded(length - strike, fine, REACH + fine, coarse)
    offset = 0.5 * fine
    heights = np.concatenate([-down[:0:-1], up])
    fading = np.where(heights >= 0.0, 1.0 - heights / strike, 1.0 + heights / (length - strike))
    heights = heights + offset * fading - strike
    depth = graded(width, fine, 2.0 * fine, 2.5e-3) if layers is None else np.linspace(0.0, width, layers + 1)
    mesh: Any = grid(-depth[::-1], heights, order=ORDER)
    hinge = int(np.argmin(np.hypot(mesh.p[0] + 0.5 * width, mesh.p[1])))
    back = int(np.argmin(np.hypot(mesh.p[0] + width, mesh.p[1] + strike)))
    face = -float(mesh.p[0, hinge])
    mesh = mesh.translated((face, 0.0))
    return Continuum(
        mesh if remake is None else remake(mesh),
        density=7800.0,
        youngs_modulus=210e9,
        poissons_ratio=0.3,
        thickness=0.02,
        sets={
            "hinge": [hinge],
            "back": [back],
            "face": lambda x, y: (abs(y + strike) < REACH + 0.6 * fine) & (x > face - 1e-9),
        },
    )


def reduced(mesh: Continuum, boundary: list[str]) -> Body:
    """Craig-Bampton: the nodes of the contact region and of joints, and 60 modes."""
    return craig_bampton(mesh, boundary, modes=60, damping=Rayleigh(0.0, 1e-9))


def pendulum_and_rod(
    rod: Continuum | None = None,
    pendulum: Continuum | None = None,
    reduce: Reduce = reduced,
    speed: float = 1.4,
    node_side: str = "rod",
) -> Scene:
    """A pendulum meets the end of a free rod at ``speed`` [m/s]; no gravity, which would move 20 µm in 2 ms.

    ``reduce`` makes a body of a mesh and the names of its sets that have contacts and joints. The nodes of
    ``node_side``, "rod" or "pendulum", meet the edges of the other.
    """
    if node_side not in ("rod", "pendulum"):
        raise ModelError(f'node_side: {shown(node_side)} was given, expected "rod" or "pendulum"')
    scene = Scene(gravity=(0.0, 0.0))
    hammer = pendulum_with_hammer() if pendulum is None else pendulum
    mesh = hammer.finite_elements()
    x, y = mesh.places[mesh.sets["face"]].mean(axis=0)
    hinge = (-float(x) - GAP, -float(y))
    body = reduce(hammer, ["face", "hinge"])
    swinging = scene.add(body, name="pendulum", position=hinge, angular_velocity=speed / hinge[1])
    struck = scene.add(reduce(rod_with_crown() if rod is None else rod, ["tip"]), name="rod")
    scene.join(Revolute(swinging.point("hinge"), scene.ground.at(*hinge), name="hinge"))
    tip, face = struck.surface("tip"), swinging.surface("face")
    scene.contact(tip, face, name="strike", node_side=tip if node_side == "rod" else face)
    return scene


def strip_with_patch(fine: float = 5e-4, coarse: float = 5e-3, reach: float = 0.665, patch: float = 1e-3) -> Continuum:
    """The strip of Shi, Hong & Liu 2013 (0.7 x 0.028 x 0.005 m, aluminium), hung at its left end, "hinge".

    Quadratic elements, ``fine`` [m] within ``patch`` [m] of its lower face at ``reach`` [m] from the hinge, the surface
    "patch"; those of the two layers of elements there are the set "region", and "back" is the point of the upper face
    right above the middle of the patch.
    """
    length, half = 0.7, 0.0025
    before, after = graded(reach, fine, patch, coarse), graded(length - reach, fine, patch, coarse)
    up = graded(2.0 * half, fine, 2.0 * fine, 2e-3)
    mesh = grid(reach + np.concatenate([-before[:0:-1], after]), up - half)
    places = mesh.doflocs
    hinge = int(np.argmin(np.hypot(*places)))
    mesh = mesh.translated((0.0, -float(places[1, hinge])))
    low, high = float(mesh.doflocs[1].min()), float(mesh.doflocs[1].max())
    back = int(np.argmin(np.hypot(mesh.doflocs[0] - reach, mesh.doflocs[1] - high)))
    edge = patch + 0.1 * fine
    return Continuum(
        mesh,
        density=2700.0,
        youngs_modulus=6.9e10,
        poissons_ratio=0.33,
        thickness=0.028,
        sets={
            "hinge": [hinge],
            "back": [back],
            "patch": lambda x, y: (abs(x - reach) < edge) & (y < low + 1e-9),
            "region": lambda x, y: (abs(x - reach) < edge) & (y < low + 2.1 * fine),
        },
    )


def pendulum_on_hemisphere(
    strip: Continuum | None = None, modes: int = 160, speed: float = 0.4, radius: float = 0.1, nodal: bool = True
) -> Scene:
    """The strip, straight and level, meets a fixed round of ``radius`` [m] at ``speed`` [m/s] with its patch.

    Nodal coordinates in the contact region and at the hinge, ``modes`` for the rest; where ``nodal`` is False, that
    many free modes of the whole strip and nothing else.
    """
    mesh = strip_with_patch() if strip is None else strip
    damping = Rayleigh(0.0, 1e-9)
    if nodal:
        body = sub_regional(mesh, ["region", "hinge"], modes=modes, damping=damping)
    else:
        body = mesh.reduce(modes, damping=damping)
    elements = mesh.finite_elements()
    x, y = elements.places[elements.sets["patch"]].mean(axis=0)
    scene = Scene()
    falling = scene.add(body, name="pendulum", angular_velocity=-speed / x)
    scene.join(Revolute(falling.point("hinge"), scene.ground.at(0.0, 0.0), name="hinge"))
    bump = scene.ground.circle(center=(x, y - radius - 0.1 * GAP), radius=radius)
    patch = falling.surface("patch")
    scene.contact(patch, bump, name="hemisphere", node_side=patch)
    return scene


def graded(extent: float, fine: float, reach: float, coarse: float, growth: float = GROWTH) -> FloatArray:
    """Places from 0 to ``extent``: steps ``fine`` up to ``reach``, then growing by ``growth`` up to ``coarse``."""
    steps = [fine] * round(reach / fine)
    while sum(steps) < extent:
        steps.append(min(growth * steps[-1], coarse))
    places = np.concatenate([[0.0], np.cumsum(steps)])
    kept = round(reach / fine)
    stretch = (extent - places[kept]) / (places[-1] - places[kept])
    places[kept:] = places[kept] + stretch * (places[kept:] - places[kept])
    return np.asarray(places)
