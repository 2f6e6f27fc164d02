"""Planar piles for MuJoCo: discs in a box, and boxes, in the plane x, z; its contacts give way (soft constraints)."""

from __future__ import annotations

import time
from typing import Any

import numpy as np
from numpy.typing import NDArray

HEAD = """<mujoco><option timestep="{step}" gravity="0 0 -9.81" cone="elliptic" solver="Newton" iterations="100"
tolerance="1e-10"/><default><geom condim="3" friction="{friction} 0 0" solref="{constant} 1"/></default><worldbody>
<geom type="plane" size="0 0 1"/>"""
SIDE = '<geom type="plane" pos="{x} 0 0" zaxis="{way} 0 0" size="0 0 1"/>'
BODY = """<body pos="{x} 0 {y}"><joint type="slide" axis="1 0 0"/><joint type="slide" axis="0 0 1"/>
<joint type="hinge" axis="0 1 0"/><inertial pos="0 0 0" mass="{mass}" diaginertia="{inertia} {inertia} {inertia}"/>
<geom {shape}/></body>"""


def model(
    bodies: list[dict[str, Any]], step: float, friction: float, width: float | None = None, constant: float = 0.02
) -> Any:
    """What MuJoCo makes of bodies {x, y, mass, inertia, shape}, on a floor and between walls ``width`` apart.

    ``constant`` [s]: of the time in which a contact comes back; 0.02 by default, twice the step at least.
    """
    import mujoco

    text = [HEAD.format(step=step, friction=friction, constant=constant)]
    if width is not None:
        text += [SIDE.format(x=0.0, way=1), SIDE.format(x=width, way=-1)]
    text += [BODY.format(**body) for body in bodies]
    return mujoco.MjModel.from_xml_string("\n".join([*text, "</worldbody></mujoco>"]))


def discs(q: NDArray[np.float64], radius: NDArray[np.float64], mass: float = 1.0) -> list[dict[str, Any]]:
    """Bodies of :func:`model`."""
    return [
        {"x": x, "y": y, "mass": mass, "inertia": 0.5 * mass * r**2, "shape": f'type="sphere" size="{r}"'}
        for (x, y), r in zip(q[:, :2], radius, strict=True)
    ]


def boxes(places: NDArray[np.float64], width: float, height: float, mass: float = 1.0) -> list[dict[str, Any]]:
    """Bodies of :func:`model`."""
    inertia = mass * (width**2 + height**2) / 12.0
    shape = f'type="box" size="{0.5 * width} {0.5 * width} {0.5 * height}"'
    return [{"x": x, "y": y, "mass": mass, "inertia": inertia, "shape": shape} for x, y in places]


def seconds_of(made: Any, steps: int, data: Any = None) -> tuple[NDArray[np.float64], Any]:
    """CPU seconds of each step, and the state at the end."""
    import mujoco

    data = mujoco.MjData(made) if data is None else data
    taken = np.empty(steps)
    for k in range(steps):
        began = time.process_time()
        mujoco.mj_step(made, data)
        taken[k] = time.process_time() - began
    return taken, data
