"""Spatial scenes and what pictures show of them, for tests."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

import lcpflex as lf
from lcpflex.bodies.spatial.body import SpatialBody
from lcpflex.compile.compiled_scene import CompiledScene
from lcpflex.jit.kernel import FloatArray
from lcpflex.results.energy_balance import Energies
from lcpflex.results.result import ContactPoints, Result
from lcpflex.results.spatial.camera import Look
from lcpflex.results.spatial.ground import level_under, patches
from lcpflex.results.spatial.picture import SpatialPicture

__all__ = ["LOOK", "SIDE", "draw_patches_of", "picture_of", "result_of", "scene_of", "sliding"]

SIDE = 0.0, -90.0  # seen along y: x to the right, z up
LOOK = Look(SIDE, False, 1.0)


def result_of(compiled: CompiledScene, q: FloatArray | None = None) -> Result:
    """A made-up motion (m, nq) of a scene; that of the start, twice, if there is none."""
    q = np.tile(compiled.q, (2, 1)) if q is None else q
    m, zero = len(q), np.zeros(len(q))
    pairs, whole = np.zeros((0, 3)), np.zeros(0, np.int64)
    return Result(
        times=0.1 * np.arange(m), q=q, u=np.tile(compiled.u, (m, 1)), force=np.zeros((m, 0, 2)),
        impulse=np.zeros((m, 0, 2)), state=np.zeros((m, 0), np.int8), gap=np.zeros((m, 0)),
        contact_points=ContactPoints(whole, whole, pairs, pairs, pairs, np.zeros(0, np.int8)),
        energies=Energies.audit(1.0 + zero, zero, zero, zero, zero, zero, zero), residual=zero, penetration=zero,
        joint_drift=zero, size=np.zeros(m, np.int64), events=(), warnings=(), complete=True, message="made up",
        steps=m, wall_time=0.1, compile_time=0.0, stepper="MoreauJean(step=0.1)", duration=0.1 * (m - 1),
        compiled=compiled,
    )  # fmt: skip


def scene_of(*bodies: tuple[SpatialBody, tuple[float, float, float]], gravity: Any = (0, 0, -9.81)) -> CompiledScene:
    scene = lf.SpatialScene(gravity=gravity)
    for body, position in bodies:
        scene.add(body, position=position)
    return scene.compiled()


def draw_patches_of(result: Result) -> list[FloatArray]:
    assert result.compiled is not None
    model, up = result.compiled.model, np.array([0.0, 0.0, 1.0])
    places = np.array([[0.0, 0.0, 0.0], [0.3, 0.2, 0.1]])
    return patches(model, places, up, level_under(model, places, up))


def picture_of(scene: lf.SpatialScene, view: tuple[float, float] = SIDE) -> tuple[SpatialPicture, CompiledScene]:
    compiled = scene.compiled()
    look = LOOK._replace(view=view)
    return SpatialPicture(result_of(compiled), compiled, np.array([0]), look), compiled


def sliding(tilt: float) -> Result:
    """A box of 2 kg that slides down a plane which leans by ``tilt`` [rad] about y, with mu = .1."""
    turned = Rotation.from_rotvec([0.0, tilt, 0.0])
    up = turned.apply([0.0, 0.0, 1.0])
    scene = lf.SpatialScene()
    box = scene.add(
        lf.Cuboid(0.2, 0.1, 0.1, mass=2.0), position=0.05 * up, orientation=turned, velocity=turned.apply([1.0, 0, 0])
    )
    scene.contact(box.surface(), scene.ground.plane((0.0, 0.0, 0.0), up), friction=0.1)
    return lf.simulate(scene, 0.02, lf.MoreauJean(step=1e-3))
