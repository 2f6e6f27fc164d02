"""Places of rest of heaps and meshes: how their time grows with contacts and coordinates."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping

import lcpflex as lf
from lcpflex import gallery


def seconds(scene: lf.Scene) -> float:
    """Of computing until it is at rest."""
    began = time.process_time()
    rest = lf.equilibrium(scene, progress=False)
    assert rest.stable
    return time.process_time() - began


def strip(elements: int) -> lf.Scene:
    """All coordinates of a steel strip of (2 elements + 1) x 5 nodes, on two round supports."""
    mesh = lf.meshes.bar(1.0, 0.1, elements, across=2)
    scene = lf.Scene()
    body = scene.add(lf.unreduced(lf.Continuum(mesh, 7800.0, 2.1e11, 0.3, thickness=0.05)), "strip", (0.0, 0.051))
    for x in (0.1, 0.9):
        scene.contact(body.surface(), scene.ground.circle((x, -0.02), 0.02), friction=0.3)
    return scene


def test_places_of_rest(interleave: Callable[..., Mapping[str, float]]) -> None:
    meshes = {elements: strip(elements) for elements in (40, 100)}
    interleave(
        {
            "heap of 30 discs at rest": lambda: seconds(gallery.heap(discs=30)),
            "heap of 100 discs at rest": lambda: seconds(gallery.heap(discs=100)),
            "mesh of 810 coordinates at rest": lambda: seconds(meshes[40]),
            "mesh of 2010 coordinates at rest": lambda: seconds(meshes[100]),
        },
        rounds=1,
    )
