"""What a joint does to its bodies follows from its rows, whatever kind of coordinate they prescribe."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import lcpflex as lf
from lcpflex.dynamics.reaction_memory import reaction
from lcpflex.jit.struct import pack
from lcpflex.kinematics import joint_rows as joints
from lcpflex.kinematics.points import point_angle, point_motion
from lcpflex.model.arrays import frozen
from lcpflex.model.coordinates import COORDINATES

RATIO, PITCH, FORCE = 2.5, 0.3, 7.0
NEW_KINDS = {  # g_x, g_y, g_P, g_Q and the bias
    "gear": (0.0, 0.0, 1.0, -RATIO, 0.0),
    "screw": (0.6, 0.8, PITCH, -PITCH, 0.0),
}


def two_wheels(P_on_ground: bool) -> Any:
    scene = lf.Scene()
    first = scene.add(lf.RigidBody(mass=2.0, inertia=0.3), "first", position=(0.2, 0.1), angle=0.4)
    second = scene.add(lf.RigidBody(mass=1.0, inertia=0.1), "second", position=(1.0, -0.3), angle=-0.7)
    ends = first.at(0.5, -0.2), (scene.ground if P_on_ground else second).at(0.1, 0.3)
    scene.join(lf.DrivenAngle(*(ends[::-1] if P_on_ground else ends), motion=0.0, name="pair"))
    return scene.compile()


@pytest.mark.parametrize("P_on_ground", [False, True])
@pytest.mark.parametrize("name", NEW_KINDS)
def test_a_new_kind_of_coordinate_makes_a_reaction(
    monkeypatch: pytest.MonkeyPatch, name: str, P_on_ground: bool
) -> None:
    """The gradient of a kind is all that tells of it: the force and the moment of its joint do the work of its row."""
    compiled = two_wheels(P_on_ground)
    monkeypatch.setattr(joints, "coordinate_gradient", lambda *_: NEW_KINDS[name])  # in plain Python: behind compile()
    kinds = compiled.model.joints._replace(kind=frozen([len(COORDINATES)], np.int64))
    work, model, q = compiled.system().workspace(2), pack(compiled.model._replace(joints=kinds)), compiled.q.copy()
    u = np.random.default_rng(1).normal(size=len(q))
    joints.joint_rows.py_func(
        model,
        0.0,
        q,
        u,
        work.free.external,
        work.rows.J,
        work.rows.body,
        work.rows.wrench,
        work.rows.rate,
        work.rows.bias,
    )
    p = np.full(len(work.impulses.p), FORCE)
    x, y, moment = reaction.py_func(model, work, 0, p)
    assert (x, y, moment) == tuple(FORCE * part for part in NEW_KINDS[name][:3])
    P = int(model.joints.point[0, 0])
    _, _, vx, vy, _, _ = point_motion(model.bodies, model.points, q, u, P)
    on_p = 0.0 if P_on_ground else work.rows.J[0, 0, :3] @ u[:3]
    assert FORCE * on_p == pytest.approx(x * vx + y * vy + moment * point_angle(model.bodies, model.points, u, P))
