"""A snap-fit hook as a solid, pushed under a catch and pulled back, against statics of the whole mesh.

The reference is the stiffness K of all nodes, held at the root, with small displacements: the nodes i of the nose touch
one side of the catch with the normal n, along which t points the way that the hook slides,

    u = K^-1 sum lambda_i (n - mu t)_i,   0 <= lambda  _|_  n.(x_i + u_i + d e_x - p) >= 0,

and the drive pushes with -sum lambda_i (n - mu t)_x. The frame of the reduced body rides on the root and does not turn,
and every node of the nose has residual modes, so that both are the same statics: differences are those of solving.
"""

from __future__ import annotations

import math
from functools import cache
from typing import NamedTuple

import numpy as np
import pytest

import lcpflex as lf
from lcpflex.bodies.fem.sparse_factor import positive_factor
from lcpflex.bodies.reduction.mesh_stress import MeshStress
from lcpflex.bodies.spatial.body import SpatialBody
from lcpflex.jit.kernel import FloatArray
from lcpflex.solvers.auto import solve_lcp
from lcpflex.solvers.mixed.problems import MixedLcp
from tests.pressed_solids import grid_block

WIDTH, HALF = 4e-3, 1e-3  # of the arm: width, half of its height [m]
ALONG, ABOVE = np.array([0.0, 18e-3, 19e-3, 20e-3]), np.array([1e-3, 1e-3, 2e-3, 2e-3])  # upper side: arm, nose
PLASTIC = {"density": 1050.0, "youngs_modulus": 2.3e9, "poissons_ratio": 0.38}
FIRST, LAST, REAR = (21e-3, 2.2e-3), (21e-3 + 1e-3 / math.tan(math.radians(30.0)), 1.2e-3), 1.5e-3
# lower side of the catch: down a ramp of 30 degrees, on the level, up 34 degrees (x, z) [m]
CATCH = (FIRST, LAST, (LAST[0] + REAR, LAST[1]), (LAST[0] + 2.0 * REAR, FIRST[1]))
RAMP, BACK = 0, 2  # sides of it
INTO, OUT = np.array([0.0, 1.4e-3, 1.8e-3, 2.2e-3, 2.6e-3]), np.array([6.6e-3, 6.2e-3, 5.8e-3])  # [m]
FARTHEST = 8e-3


@cache
def hook() -> tuple[lf.Solid, SpatialBody]:
    """Elements of 20 nodes; the frame of the body is that of the root."""
    along = np.concatenate([np.linspace(0.0, 18e-3, 7), [18.5e-3, 19e-3, 19.5e-3, 20e-3]])
    lines = [along, np.linspace(-0.5 * WIDTH, 0.5 * WIDTH, 3), np.linspace(-HALF, HALF, 3)]

    def shaped(places: FloatArray) -> FloatArray:
        x, y, z = places.T
        share = 0.5 * (z + HALF) / HALF
        return np.column_stack([x, y, share * (np.interp(x, ALONG, ABOVE) + HALF) - HALF])

    def on_nose(x: FloatArray, y: FloatArray, z: FloatArray) -> FloatArray:
        return (x > ALONG[2] - 1e-9) & (z > ABOVE[2] - 1e-9)

    sets = {"root": lambda x, y, z: x < 1e-9, "nose": on_nose}
    solid = lf.Solid(grid_block("hexahedron20", lines, bend=shaped), sets=sets, **PLASTIC)
    return solid, solid.reduce(modes=6, clamped="root", contact="nose")


def scene(friction: float) -> lf.SpatialScene:
    made = lf.SpatialScene(gravity=(0.0, 0.0, 0.0))
    solid, body = hook()
    placed = made.add(body, "hook")
    corners = [*CATCH, (CATCH[-1][0], 4e-3), (CATCH[0][0], 4e-3)]
    catch = made.ground.hull([(x, y, z) for x, z in corners for y in (-WIDTH, WIDTH)])
    made.contact(placed.face("nose"), catch, friction=friction, points="nodes", name="catch")
    root = placed.at_nodes(np.flatnonzero(solid.finite_elements().places[:, 0] < 1e-9).tolist())
    place = made.ground.at(0.0, 0.0, 0.0)
    made.join(lf.Prismatic(root, place, axis=(1.0, 0.0, 0.0), name="guide"))
    made.join(lf.DrivenDisplacement(root, place, 0.0, (1.0, 0.0, 0.0), name="push"))
    return made


class Pushed(NamedTuple):
    force: float  # of the drive [N]
    moved: FloatArray  # (N, 3) nodes from the frame of the root [m]


def of_the_mesh(d: float, friction: float, way: float, side: int) -> Pushed:
    """The reference at a place of the drive, which goes that way (1 in, -1 out)."""
    mesh = hook()[0].finite_elements()
    (x, z), (x_end, z_end) = CATCH[side : side + 2]
    along = np.array([x_end - x, 0.0, z_end - z]) / math.hypot(x_end - x, z_end - z)
    normal = np.array([along[2], 0.0, -along[0]])
    push = normal - friction * way * along
    nose = np.unique(mesh.facets[mesh.faces["nose"]])
    free = np.repeat(mesh.places[:, 0] > 1e-9, 3)
    rows = np.zeros((2, len(nose), len(mesh.places), 3))
    rows[0, np.arange(len(nose)), nose], rows[1, np.arange(len(nose)), nose] = normal, push
    measured, pushing = rows.reshape(2, len(nose), -1)
    factor = positive_factor(mesh.stiffness.tocsc()[free][:, free].tocsc(), mesh.rank[free])
    by_each = np.zeros((len(free), len(nose)))
    by_each[free] = factor.solve(pushing[:, free].T)
    gap = (mesh.places[nose] + np.array([d - x, 0.0, -z])) @ normal
    pressed = solve_lcp(MixedLcp(measured @ by_each, gap, np.zeros(len(nose), bool))).z
    return Pushed(-float(push[0] * pressed.sum()), (by_each @ pressed).reshape(-1, 3))


@pytest.mark.parametrize("friction", [0.0, 0.3])
def test_insertion_and_retention(friction: float) -> None:
    """Along the ramp in and along the back out, to the accuracy of places of rest; behind the catch it is free."""
    between = np.array([3.5e-3, 5e-3])
    path = lf.path(scene(friction), "push", [*INTO, *between, FARTHEST, *OUT], progress=False)
    assert path.complete
    assert path.force is not None
    into, out = path.force[: len(INTO)], path.force[-len(OUT) :]
    assert into == pytest.approx([of_the_mesh(d, friction, 1.0, RAMP).force for d in INTO], rel=1e-6, abs=1e-9)
    assert out == pytest.approx([of_the_mesh(d, friction, -1.0, BACK).force for d in OUT], rel=1e-6, abs=1e-9)
    assert path.force[-len(OUT) - 1] == pytest.approx(0.0, abs=1e-9)
    states = path.contact("catch").state
    assert states[: len(INTO)] == ("open", *["slip"] * (len(INTO) - 1))
    assert states[-len(OUT) - 1] == "open"
    tangential = np.linalg.norm(path.contact("catch").tangential, axis=1)
    assert tangential == pytest.approx(friction * path.contact("catch").normal, rel=1e-6, abs=1e-9)


def test_stress_is_that_of_the_mesh() -> None:
    """Of the modes alone at all nodes, and with the static part away from the root, just behind the first touch.

    The joint holds the mean of the root there, not each of its nodes; at the end of the ramp the moment of the axial
    force by the deflection, which linear modes leave out, is 3 % of the other. Friction would turn a little with the
    nodes that move aside, which the reference leaves out.
    """
    touched = 1.36e-3
    path = lf.path(scene(0.0), "push", [0.0, touched, INTO[-1]], progress=False)
    shapes = path[-1].compiled.recovery[0]
    assert shapes is not None
    mesh = MeshStress(shapes, np.arange(shapes.phi.shape[2]))
    expected = stress_of(mesh, of_the_mesh(float(INTO[-1]), 0.0, 1.0, RAMP).moved)
    largest = np.abs(expected).max()
    assert largest > 1e7
    found = path[-1].stress("hook", static=False)
    stored = np.array([found.xx, found.yy, found.xy, found.zz, found.yz, found.zx])
    assert np.abs(stored - expected).max() < 1e-6 * largest
    little = stress_of(mesh, of_the_mesh(touched, 0.0, 1.0, RAMP).moved)[0]
    whole = path[1].stress("hook")
    away = whole.places[:, 0] > 9e-3
    assert np.abs(whole.xx - little)[away].max() < 1e-3 * np.abs(little).max()


def stress_of(mesh: MeshStress, moved: FloatArray) -> FloatArray:
    """(6, N) [Pa] of displacements (N, 3)."""
    return mesh.stress(moved[:, :, None])[:, :, 0]
