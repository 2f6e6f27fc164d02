"""Spheres in an open box for MuJoCo and Drake; contacts of both give way."""

from __future__ import annotations

import time
from typing import Any

import numpy as np
from numpy.typing import NDArray

GRAVITY, MASS = 9.81, 1.0
HEAD = """<mujoco><option timestep="{step}" gravity="0 0 -9.81" cone="elliptic" solver="Newton" iterations="100"
tolerance="1e-10"/><default><geom condim="3" friction="{friction} 0 0" solref="{constant} 1"/></default><worldbody>"""
PLANE = '<geom type="plane" pos="{x} {y} 0" zaxis="{a} {b} {c}" size="0 0 1"/>'
BALL = """<body pos="{x} {y} {z}"><freejoint/><inertial pos="0 0 0" mass="1" diaginertia="{i} {i} {i}"/>
<geom type="sphere" size="{r}"/></body>"""


def walls(width: float) -> list[tuple[tuple[float, float, float], tuple[float, float, float]]]:
    """Places and normals of the planes of a box that is open above, [0, width]^2 x [0, inf)."""
    return [
        ((0.0, 0.0, 0.0), (0.0, 0.0, 1.0)),
        ((0.0, 0.0, 0.0), (1.0, 0.0, 0.0)),
        ((width, 0.0, 0.0), (-1.0, 0.0, 0.0)),
        ((0.0, 0.0, 0.0), (0.0, 1.0, 0.0)),
        ((0.0, width, 0.0), (0.0, -1.0, 0.0)),
    ]


class MuJoCo:
    """Newton's method with elliptic cones; ``constant`` [s]: of the time in which a contact comes back."""

    def __init__(
        self, places: NDArray[np.float64], radius: float, width: float, friction: float, step: float, constant: float
    ) -> None:
        import mujoco

        text = [HEAD.format(step=step, friction=friction, constant=constant)]
        text += [PLANE.format(x=p[0], y=p[1], a=n[0], b=n[1], c=n[2]) for p, n in walls(width)]
        inertia = 0.4 * MASS * radius**2
        text += [BALL.format(x=x, y=y, z=z, i=inertia, r=radius) for x, y, z in places]
        self._step = mujoco.mj_step
        self._model: Any = mujoco.MjModel.from_xml_string("\n".join([*text, "</worldbody></mujoco>"]))
        self._data: Any = mujoco.MjData(self._model)

    def advance(self, steps: int) -> float:
        """CPU seconds of so many steps."""
        began = time.process_time()
        for _ in range(steps):
            self._step(self._model, self._data)
        return time.process_time() - began

    def state(self) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
        """Places, velocities and angular velocities, (n, 3) each."""
        u = self._data.qvel.reshape(-1, 6)
        return self._data.qpos.reshape(-1, 7)[:, :3].copy(), u[:, :3].copy(), u[:, 3:].copy()


class Drake:
    """Its semi-analytic primal solver (SAP) with point contacts, near-rigid: as stiff as its step allows."""

    def __init__(self, places: NDArray[np.float64], radius: float, width: float, friction: float, step: float) -> None:
        from pydrake.geometry import HalfSpace, Sphere
        from pydrake.math import RigidTransform
        from pydrake.multibody.plant import AddMultibodyPlantSceneGraph, ContactModel, CoulombFriction
        from pydrake.multibody.tree import SpatialInertia
        from pydrake.systems.analysis import Simulator
        from pydrake.systems.framework import DiagramBuilder

        builder = DiagramBuilder()
        self._plant: Any
        self._plant, _ = AddMultibodyPlantSceneGraph(builder, step)
        plant, rough, self._time_step = self._plant, CoulombFriction(friction, friction), step
        plant.set_contact_model(ContactModel.kPoint)
        for k, (place, normal) in enumerate(walls(width)):
            pose = HalfSpace.MakePose(np.array(normal), np.array(place))
            plant.RegisterCollisionGeometry(plant.world_body(), pose, HalfSpace(), f"wall{k}", rough)
        inertia = SpatialInertia.SolidSphereWithMass(MASS, radius)
        self._balls = [plant.AddRigidBody(f"ball{k}", inertia) for k in range(len(places))]
        for k, ball in enumerate(self._balls):
            plant.RegisterCollisionGeometry(ball, RigidTransform(), Sphere(radius), f"ball{k}", rough)
        plant.Finalize()
        self._diagram: Any = builder.Build()
        self._simulator: Any = Simulator(self._diagram)
        self._context: Any = plant.GetMyMutableContextFromRoot(self._simulator.get_mutable_context())
        for ball, place in zip(self._balls, places, strict=True):
            plant.SetFreeBodyPose(self._context, ball, RigidTransform(np.array(place)))
        self._simulator.Initialize()

    def advance(self, steps: int) -> float:
        """CPU seconds of so many steps."""
        end = self._simulator.get_context().get_time() + steps * self._time_step
        began = time.process_time()
        self._simulator.AdvanceTo(end)
        return time.process_time() - began

    def state(self) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
        """Places, velocities and angular velocities, (n, 3) each."""
        poses = [self._plant.EvalBodyPoseInWorld(self._context, ball).translation() for ball in self._balls]
        rates = [self._plant.EvalBodySpatialVelocityInWorld(self._context, ball) for ball in self._balls]
        return np.array(poses), np.array([r.translational() for r in rates]), np.array([r.rotational() for r in rates])
