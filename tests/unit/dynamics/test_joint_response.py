"""Joints by their sparse factor, against the dense formulas; redundant ones, and what no longer grows with n^2."""

from __future__ import annotations

import math
from collections.abc import Callable
from itertools import pairwise
from typing import Any

import numpy as np
import pytest

import lcpflex as lf
from lcpflex.contact.detection import detect
from lcpflex.dynamics.acceleration import contact_sets, lay_rows
from lcpflex.dynamics.contact_problem import lay_contacts, pose_island
from lcpflex.dynamics.islands import one_island
from lcpflex.dynamics.joint_response import factorise_joints, joint_impulses, respond, solve_joints
from lcpflex.dynamics.workspace import Workspace
from lcpflex.jit.kernel import FloatArray
from lcpflex.jit.struct import parts_of
from lcpflex.solvers.contact.algebra import PLANAR
from lcpflex.steppers.system import System
from tests.scenes import floor_of

LENGTH = 0.2


def link(scene: lf.Scene, name: str, x: float, y: float = 0.0, angle: float = 0.0, mass: float = 1.0) -> lf.Placed:
    """A bar."""
    body = lf.RigidBody(mass=mass, inertia=mass * LENGTH**2 / 12)
    return scene.add(body, name, position=(x, y), angle=angle)


def chain(n: int, closed: bool = False, order: int = 1, contacts: bool = True) -> lf.Scene:
    """Links along the x axis, hinged to the ground at the start, and at the end where ``closed``."""
    scene = lf.Scene()
    bodies = [link(scene, f"link{i}", (i + 0.5) * LENGTH, mass=1.0 + 0.3 * (i % 3)) for i in range(n)]
    joints = [lf.Revolute(bodies[0].at(-LENGTH / 2, 0), scene.ground.at(0, 0))]
    joints += [lf.Revolute(b.at(-LENGTH / 2, 0), a.at(LENGTH / 2, 0)) for a, b in pairwise(bodies)]
    if closed:
        joints.append(lf.Revolute(bodies[-1].at(LENGTH / 2, 0), scene.ground.at(n * LENGTH, 0)))
    for joint in joints[::order]:
        scene.join(joint)
    if contacts:
        touch(scene, bodies)
    return scene


def touch(scene: lf.Scene, bodies: list[lf.Placed]) -> None:
    """Contacts of the middle of each third body with a floor beneath, every second one with friction."""
    floor = floor_of(scene)
    for i, body in enumerate(bodies[::3]):
        scene.contact(body.node(0.0, 0.0), floor, friction=0.4 * (i % 2))


def tree(n: int) -> lf.Scene:
    """Each link hinged to the middle of another one, by each kind of joint in turn."""
    scene = lf.Scene()
    bodies = [link(scene, f"link{i}", 0.1 * i, angle=0.1 * i) for i in range(n)]
    scene.join(lf.Weld(bodies[0].at(0, 0), scene.ground.at(0, 0)))
    kinds: list[Callable[[lf.PlacedPoint, lf.PlacedPoint], object]] = [
        lf.Revolute,
        lambda P, Q: lf.Prismatic(P, Q, axis=(0.6, 0.8)),
        lambda P, Q: lf.PointOnLine(P, Q, axis=(0.6, -0.8)),
        lf.Weld,
        lf.Distance,
    ]
    for i in range(1, n):
        parent = bodies[(i - 1) // 2]
        kind = kinds[i % len(kinds)]
        away = (0.3, 0.2) if kind is lf.Distance else (0.0, 0.0)
        scene.join(kind(bodies[i].at(0, 0), parent.at(*(place_in(parent, bodies[i]) + away))))
    touch(scene, bodies)
    return scene


def place_in(parent: lf.Placed, body: lf.Placed) -> FloatArray:
    """The origin of ``body`` in the frame of ``parent``."""
    (x, y), angle = body.start[0][:2] - parent.start[0][:2], parent.start[0][2]
    return np.array([math.cos(angle) * x + math.sin(angle) * y, math.cos(angle) * y - math.sin(angle) * x])


def lattice(k: int, shift: int = 0, contacts: bool = True) -> lf.Scene:
    """Braced squares of bars, each hinged to the first one that came to its node: as many loops as bars, redundant."""
    scene = lf.Scene()
    nodes = {(i, j): np.array([i, j]) * 0.5 + 0.02 * np.sin([i * j, i + 2 * j]) for i in range(k) for j in range(k)}
    steps = [(1, 0), (0, 1), (1, 1), (1, -1)]
    bars = [(n, (n[0] + i, n[1] + j)) for n in nodes for i, j in steps if (n[0] + i, n[1] + j) in nodes]
    first = {n: scene.ground.at(*nodes[n]) for n in ((0, 0), (1, 0))}
    placed, joints = [], []
    for b, (start, end) in enumerate(bars):
        d = nodes[end] - nodes[start]
        body = link(scene, f"bar{b}", *(0.5 * (nodes[start] + nodes[end])), angle=math.atan2(d[1], d[0]))
        placed.append(body)
        for node, x in ((start, -0.5), (end, 0.5)):
            end_point = body.at(x * float(np.hypot(*d)), 0.0)
            if node in first:
                joints.append(lf.Revolute(end_point, first[node]))
            else:
                first[node] = end_point
    for joint in joints[shift:] + joints[:shift]:
        scene.join(joint)
    if contacts:
        touch(scene, placed)
    return scene


SCENES: dict[str, Callable[[], lf.Scene]] = {
    "chain": lambda: chain(12),
    "chain declared backwards": lambda: chain(12, order=-1),
    "closed chain": lambda: chain(9, closed=True),
    "tree": lambda: tree(14),
    "lattice": lambda: lattice(3),
    "no contact on joints": lambda: chain(1),
}


def laid(system: System, n: int | None = None) -> tuple[Workspace, FloatArray, FloatArray]:
    """A workspace with all rows laid, the rows as a matrix, and M^-1 times them, both by rows."""
    work, q, u = system.workspace(64), system.q.copy(), system.u.copy()
    found = int(detect(system.model, q, 10.0, work.rows.table)) if n is None else n
    lay_rows(system.model, 0.0, q, u, found, work, contact_sets(64))
    total = work.rows.n_joint + work.rows.n_contacts + work.rows.n_tangents
    W, solved = np.zeros((total, len(q))), np.zeros((total, len(q)))
    for r in range(total):
        for i, b in enumerate(work.rows.body[r]):
            if b >= 0:
                d = slice(work.rows.dof[b], work.rows.dof[b + 1])
                W[r, d] += work.rows.J[r, i, : d.stop - d.start]
                solved[r, d] += work.rows.solved[r, i, : d.stop - d.start]
    work.free.v[:total] = W @ np.random.default_rng(0).standard_normal(len(q))
    return work, W, solved


@pytest.mark.parametrize("name", SCENES)
def test_condensed_contacts(name: str) -> None:
    """G_c = G_WW - G_WJ S^+ G_JW, b_c and the impulses of the joints that cancel all rates of them."""
    work, W, solved = laid(SCENES[name]().compile().system())
    n, total = work.rows.n_joint, len(W)
    assert work.rows.n_contacts >= 1
    G, b = W @ solved.T, work.free.v[:total].copy()
    lay_contacts(work)
    one_island(work.posed.islands, work.rows.n_contacts)
    pose_island(work, 0, PLANAR)
    pinned = np.linalg.pinv(G[:n, :n], rcond=1e-9, hermitian=True)
    scale = np.abs(G[n:, n:]).max()
    m = total - n
    assert work.posed.problem.delassus[:m, :m] == pytest.approx(
        G[n:, n:] - G[n:, :n] @ pinned @ G[:n, n:], abs=1e-10 * scale
    )
    assert np.array_equal(work.posed.problem.delassus[:m, :m], work.posed.problem.delassus[:m, :m].T)
    assert work.posed.problem.free[:m] == pytest.approx(b[n:] - G[n:, :n] @ pinned @ b[:n], abs=1e-10 * np.abs(b).max())
    for loaded in (True, False):
        work.impulses.p[:total] = np.random.default_rng(1).standard_normal(total) if loaded else 0.0
        joint_impulses(work.rows, total, work.impulses.p)
        rates = b + G @ work.impulses.p[:total]
        assert rates[:n] == pytest.approx(np.zeros(n), abs=1e-11 * np.abs(b).max())
        condensed = work.posed.problem.free[:m] + work.posed.problem.delassus[:m, :m] @ work.impulses.p[n:total]
        assert rates[n:] == pytest.approx(condensed, abs=1e-10 * np.abs(b).max())


@pytest.mark.parametrize("name", SCENES)
def test_a_unit_impulse(name: str) -> None:
    """What the joints answer to one row alone, and how much of its rate they take."""
    work, W, solved = laid(SCENES[name]().compile().system())
    n = work.rows.n_joint
    factorise_joints(work.rows)
    G = W @ solved.T
    for r in range(n, len(W)):
        taken = respond(work.rows, r)
        assert G[:n, :n] @ work.rows.joints.answer == pytest.approx(G[:n, r], abs=1e-11)
        assert taken == pytest.approx(G[r, :n] @ work.rows.joints.answer, abs=1e-11)


def test_redundant_joints_are_met_to_rounding() -> None:
    """Pivots of a lattice are small beside its dependent rows: an answer is corrected until it meets all rates."""
    work, W, solved = laid(lattice(5, contacts=False).compile().system(), n=0)
    n = work.rows.n_joint
    assert work.rows.joints.factor.dependent == 0
    factorise_joints(work.rows)
    S = W @ solved.T
    surplus = n - np.linalg.matrix_rank(S, tol=1e-9 * S.max(), hermitian=True)
    assert 0 < work.rows.joints.factor.dependent <= surplus
    b = S @ np.random.default_rng(2).standard_normal(n)
    x = b.copy()
    solve_joints(work.rows, x)
    assert S @ x == pytest.approx(b, abs=1e-12 * np.abs(b).max())
    assert np.count_nonzero(x) == n - work.rows.joints.factor.dependent
    assert np.abs(x).max() < 1e5 * np.abs(np.linalg.pinv(S, rcond=1e-10, hermitian=True) @ b).max()


def test_contradicting_rates_end() -> None:
    """Rates that no motion has cannot be met: what is left stays, and is not made worse."""
    work, W, solved = laid(lattice(3, contacts=False).compile().system(), n=0)
    factorise_joints(work.rows)
    S = W @ solved.T
    values, vectors = np.linalg.eigh(S)
    null = vectors[:, values < 1e-9 * values.max()]
    b = S @ np.ones(len(S)) + 1e-3 * null.sum(axis=1)
    x = b.copy()
    solve_joints(work.rows, x)
    kept = x != 0.0
    assert (S @ x - b)[kept] == pytest.approx(np.zeros(kept.sum()), abs=1e-11 * np.abs(b).max())


def test_the_motion_of_redundant_joints_does_not_depend_on_their_order() -> None:
    runs = [lf.simulate(lattice(3, shift), 0.05, lf.MoreauJean(1e-3), progress=False) for shift in (0, 5, 11)]
    for run in runs[1:]:
        assert run.q == pytest.approx(runs[0].q, abs=1e-12)


@pytest.mark.parametrize("stepper", [lf.MoreauJean(1e-3), lf.GeneralizedAlpha(1e-3), lf.EventDriven(), lf.Smooth()])
def test_chains_move_alike_however_they_are_declared(stepper: Any) -> None:
    runs = [lf.simulate(chain(8, order=k, contacts=False), 0.1, stepper, progress=False) for k in (1, -1)]
    assert runs[1].q[-1] == pytest.approx(runs[0].q[-1], abs=1e-9)


def test_memory_grows_with_the_links() -> None:
    """No array of joints squared, nor of joints times contacts."""

    def size(values: object) -> int:
        return sum(
            part.nbytes if isinstance(part, np.ndarray) else size(part) if hasattr(part, "_parts") else 0
            for part in parts_of(values).values()
        )

    sizes = [[size(chain(n).compile().system().workspace(room)) for n in (60, 120, 240)] for room in (1, 32)]
    for less, some, more in sizes:
        assert more - some == pytest.approx(2 * (some - less), rel=0.01)
    assert sizes[1][2] - sizes[0][2] < 1.1 * (sizes[1][0] - sizes[0][0])
