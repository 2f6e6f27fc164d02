"""What is linear, counted and not timed: entries and operations of joint factors, bytes of memory of contacts."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise

import numpy as np
import pytest

import lcpflex as lf
from lcpflex.jit.struct import parts_of
from lcpflex.solvers import Auto
from lcpflex.steppers.driver import dense_limit
from tests.rates import rate

LINKS = (100, 300, 1000)


def chain(n: int, closed: bool) -> lf.Scene:
    """Hinged links, one end or both hinged to the ground."""
    scene = lf.Scene()
    body = lf.RigidBody(mass=1.0, inertia=1e-3)
    links = [scene.add(body, f"link {k}", position=(0.1 * k + 0.05, 0.0)) for k in range(n)]
    scene.join(lf.Revolute(links[0].at(-0.05, 0.0), scene.ground.at(0.0, 0.0)))
    for one, other in pairwise(links):
        scene.join(lf.Revolute(other.at(-0.05, 0.0), one.at(0.05, 0.0)))
    if closed:
        scene.join(lf.Revolute(links[-1].at(0.05, 0.0), scene.ground.at(0.1 * n, 0.0)))
    return scene


def tree(n: int) -> lf.Scene:
    """Each link hinged to the one of half its number."""
    scene = lf.Scene()
    body = lf.RigidBody(mass=1.0, inertia=1e-3)
    ends = [scene.ground.at(0.0, 0.0)]
    for k in range(1, n + 1):
        link = scene.add(body, f"link {k}", position=(0.05 + 0.1 * (k.bit_length() - 1), 0.0))
        scene.join(lf.Revolute(link.at(-0.05, 0.0), ends[k // 2]))
        ends.append(link.at(0.05, 0.0))
    return scene


@pytest.mark.parametrize("build", [lambda n: chain(n, False), lambda n: chain(n, True), tree])
def test_the_factor_of_joints_grows_with_the_links(build: Callable[[int], lf.Scene]) -> None:
    entries, operations = [], []
    for n in LINKS:
        factor = build(n).compile().system().workspace(1).rows.joints.factor
        below = np.diff(factor.start)
        entries.append(int(below.sum()))
        operations.append(int((below.astype(int) ** 2).sum()))
    assert min(count / n for count, n in zip(entries, LINKS, strict=True)) >= 3.0  # the blocks of the hinges themselves
    assert rate(LINKS, entries) < 1.02
    assert rate(LINKS, operations) < 1.02


def bytes_of(values: object) -> int:
    """Of all arrays in a struct."""
    return sum(
        part.nbytes if isinstance(part, np.ndarray) else bytes_of(part) if hasattr(part, "_parts") else 0
        for part in parts_of(values).values()
    )


def test_memory_of_a_step_grows_with_bodies_and_contacts() -> None:
    """No array of contacts squared, nor of bodies times contacts, beyond the size of dense problems."""
    sizes, dense = (100, 200, 400), dense_limit(Auto())
    needed = []
    for n in sizes:
        scene = lf.Scene()
        scene.ground.half_plane((0.0, 0.0), (0.0, 1.0))
        for k in range(n):
            scene.add(lf.Disc(0.05, mass=1.0), position=(0.101 * (k % 20), 0.051 + 0.101 * (k // 20)))
        scene.contact_all(friction=0.5)
        needed.append(bytes_of(scene.compiled().system().workspace(3 * n, dense=dense)))
    assert needed[2] - needed[1] == pytest.approx(2 * (needed[1] - needed[0]), rel=0.01)
    assert needed[2] / (3 * sizes[2]) < 20_000  # bytes a contact
