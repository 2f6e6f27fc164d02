"""Mechanisms of many joints: a step takes a time that grows with the number of links."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping

import numpy as np
import pytest

import lcpflex as lf

STEP, STEPS = 1e-5, 2000  # so many that what happens once in a run is little beside them
LINKS = (100, 300, 1000)
GROWTH = 1.2  # exponent


def chain(n: int, closed: bool = False) -> lf.Scene:
    """Links of 0.1 m, hinged to each other and to the ground at one end or at both; nothing touches."""
    scene = lf.Scene()
    last = scene.ground.at(0.0, 0.0)
    for k in range(n):
        link = scene.add(lf.RigidBody(mass=1.0, inertia=8e-4), f"link{k}", position=(0.1 * k + 0.05, 0.0))
        scene.join(lf.Revolute(link.at(-0.05, 0.0), last))
        last = link.at(0.05, 0.0)
    if closed:
        scene.join(lf.Revolute(last, scene.ground.at(0.1 * n, 0.0)))
    return scene


def ring(n: int) -> lf.Scene:
    """A regular polygon of links, a closed loop that falls freely."""
    scene = lf.Scene()
    radius = 0.05 / math.sin(math.pi / n)
    links = []
    for k in range(n):
        angle = 2.0 * math.pi * k / n
        middle = radius * math.cos(math.pi / n)
        place = (middle * math.cos(angle), middle * math.sin(angle))
        body = lf.RigidBody(mass=1.0, inertia=8e-4)
        links.append(scene.add(body, f"link{k}", position=place, angle=angle + math.pi / 2))
    for k in range(n):
        scene.join(lf.Revolute(links[k].at(-0.05, 0.0), links[k - 1].at(0.05, 0.0)))
    return scene


def tree(n: int) -> lf.Scene:
    """Each link hinged to the end of the one of half its number."""
    scene = lf.Scene()
    ends = [scene.ground.at(0.0, 0.0)]
    for k in range(1, n + 1):
        depth = int(math.log2(k))
        link = scene.add(lf.RigidBody(mass=1.0, inertia=8e-4), f"link{k}", position=(0.1 * depth + 0.05, 0.0))
        scene.join(lf.Revolute(link.at(-0.05, 0.0), ends[k // 2]))
        ends.append(link.at(0.05, 0.0))
    return scene


def independent(n: int) -> lf.Scene:
    """Pendulums side by side."""
    scene = lf.Scene()
    for k in range(n):
        link = scene.add(lf.RigidBody(mass=1.0, inertia=8e-4), f"link{k}", position=(k + 0.05, 0.0))
        scene.join(lf.Revolute(link.at(-0.05, 0.0), scene.ground.at(float(k), 0.0)))
    return scene


MECHANISMS: dict[str, Callable[[int], lf.Scene]] = {
    "open chain": chain,
    "chain held at both ends": lambda n: chain(n, closed=True),
    "ring": ring,
    "tree": tree,
    "pendulums": independent,
}


@pytest.mark.parametrize("name", MECHANISMS)
def test_growth_with_the_links(name: str, interleave: Callable[..., Mapping[str, float]]) -> None:
    """Exponent of the time of a step, fitted over a decade of links."""
    scenes = {n: MECHANISMS[name](n) for n in LINKS}

    def contestant(n: int) -> Callable[[], float]:
        def run() -> float:
            began = time.process_time()
            lf.simulate(scenes[n], STEPS * STEP, lf.MoreauJean(STEP), record=STEPS * STEP, progress=False)
            return (time.process_time() - began) / STEPS

        return run

    medians = interleave({f"{name}, {n} links": contestant(n) for n in LINKS}, rounds=3)
    assert np.polyfit(np.log(LINKS), np.log(list(medians.values())), 1)[0] < GROWTH
