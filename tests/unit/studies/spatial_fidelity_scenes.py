"""Scenes in space of which it is known how many modes they need: by the full mesh, and by a finer one."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

import lcpflex as lf
from tests.unit.studies.fidelity_scenes import STEEL, Question


@dataclass(frozen=True)
class SpatialQuestion(Question):
    """``finer`` builds the scene with a mesh twice as fine and very many modes."""

    finer: partial[lf.SpatialScene] | None = None


def strip(elements: int = 16, modes: int | None = 2) -> lf.SpatialScene:
    """A flat strip on a ball joint swings askew against a ball of the ground: it bends in two planes and twists."""
    scene = lf.SpatialScene(gravity=(0.0, 0.0, 0.0))
    width, thickness, length = 0.028, 0.01, 0.7
    beam = lf.SpatialBeam(
        length, width * thickness, (width * thickness**3 / 12.0, width**3 * thickness / 12.0), 8e-9,
        density=2700.0, youngs_modulus=6.9e10, poissons_ratio=0.3, elements=elements,
    )  # fmt: skip
    middle, turning = (0.5 * length, 0.0, 0.0), (0.0, 1.0, 0.4)
    moving = (0.0, 0.5 * length * turning[2], -0.5 * length * turning[1])
    many = 6 * elements if modes is None else modes
    arm = scene.add(beam, "arm", position=middle, velocity=moving, angular_velocity=turning, modes=many, damping=0.02)
    scene.join(lf.Ball(arm.point("left"), scene.ground.at(0.0, 0.0, 0.0)))
    stop = scene.ground.sphere((0.5, 0.012, -0.013), 0.0119)
    scene.contact(arm.sphere(arm.at(0.15, 0.0, 0.0), 0.005), stop, friction=0.3, restitution=0.0)
    return scene


def bar(size: float = 0.01, modes: int = 2) -> lf.SpatialScene:
    """A bar of hexahedra, rolled by 20 degrees, lands on a rounded corner: it turns, bends both ways and twists."""
    from scipy.spatial.transform import Rotation

    scene = lf.SpatialScene(gravity=(0.0, 0.0, 0.0))
    part = lf.Solid.bar(0.2, 0.02, 0.01, size=size, poissons_ratio=0.3, **STEEL)
    rolled = Rotation.from_euler("x", 20.0, degrees=True)
    body = scene.add(
        part.reduce(modes, damping=0.02), "bar", position=(0.0, 0.0, 0.0104), orientation=rolled,
        velocity=(0.0, 0.2, -1.0),
    )  # fmt: skip
    corner = body.sphere(body.at(0.1, -0.01, -0.005), 1e-3)
    scene.contact(corner, scene.ground.plane((0.0, 0.0, 8e-4), (0.0, 0.0, 1.0)), friction=0.2, restitution=0.0)
    return scene


SPATIAL = {
    "strip": SpatialQuestion(
        strip, 0.03, lf.GeneralizedAlpha(step=5e-6), 0.05, outputs=("motion",), finer=partial(strip, 32, None)
    ),
    "bar": SpatialQuestion(bar, 6e-3, lf.GeneralizedAlpha(step=2e-6), 0.05, finer=partial(bar, 0.005, 100)),
}
