"""Joints and loads of space."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np

import lcpflex as lf
from lcpflex.results.contact_history import ContactHistory, untouched
from tests.property.fuzz.face import Face

__all__ = ["spatial_parts_faces"]


def _points() -> dict[str, Any]:
    scene = lf.SpatialScene()
    body = scene.add(lf.Sphere(0.1, mass=1.0), name="ball", position=(0.0, 0.0, 0.5))
    return {"P": body.at(0.0, 0.0, 0.1), "Q": scene.ground.at(0.0, 0.0, 0.6)}


def _join(joint: Any = None) -> Any:
    given = _points()
    return given["P"].scene.join(lf.Ball(**given) if joint is None else joint)


def _load(load: Any = None) -> Any:
    given = _points()
    return given["P"].scene.load(lf.Spring(**given, stiffness=1.0) if load is None else load)


def _sensor(sensor: Any = None) -> Any:
    given = _points()
    return given["P"].scene.sensor(lf.sensors.Point(given["P"]) if sensor is None else sensor)


def _surfaces() -> dict[str, Any]:
    scene = lf.SpatialScene()
    ball = scene.add(lf.Sphere(0.1, mass=1.0), name="ball", position=(0.0, 0.0, 0.5))
    return {"a": ball.surface(), "b": scene.ground.plane((0.0, 0.0, 0.0), (0.0, 0.0, 1.0))}


def _contact(
    friction: Any = 0.0,
    restitution: Any = 0.0,
    tangential_restitution: Any = 0.0,
    node_side: Any = None,
    law: Any = None,
    points: Any = None,
) -> Any:
    given = _surfaces()
    if points is not None:
        block = given["a"].scene.add(_solid(), "block", modes=0)
        given["a"] = block.face("left")
    numbers = {"friction": friction, "restitution": restitution, "tangential_restitution": tangential_restitution}
    return given["a"].scene.contact(**given, **numbers, node_side=node_side, law=law, points=points)


def _sides(a: Any = None, b: Any = None) -> Any:
    given = _surfaces()
    return given["a"].scene.contact(given["a"] if a is None else a, given["b"] if b is None else b)


@cache
def _solid() -> lf.Solid:
    steel = {"density": 7800.0, "youngs_modulus": 2e11, "poissons_ratio": 0.3}
    return lf.Solid.bar(0.2, 0.02, 0.01, elements=(4, 1, 1), **steel)


def _hinge_with_play(
    pin_radius: Any = 0.02,
    hole_radius: Any = 0.021,
    friction: Any = 0.1,
    restitution: Any = 0.0,
    tangential_restitution: Any = 0.0,
    name: str | None = None,
    axis: Any = (0.0, 1.0, 0.0),
    length: Any = 0.1,
    axis_p: Any = None,
    pin_length: Any = None,
    axial_play: Any = 1e-3,
    collar_radius: Any = None,
    law: Any = None,
) -> str:
    scene = lf.SpatialScene()
    ball = scene.add(lf.Sphere(0.1, mass=1.0), name="ball")
    return scene.revolute_with_clearance(
        ball.point("center"), scene.ground.at(0.0, 0.0, 0.0), pin_radius, hole_radius, friction, restitution,
        tangential_restitution, name, axis=axis, length=length, axis_p=axis_p, pin_length=pin_length,
        axial_play=axial_play, collar_radius=collar_radius, law=law,
    )  # fmt: skip


def spatial_parts_faces() -> list[Face]:
    axis = (0.0, 0.0, 1.0)

    def part(name: str, label: str = "", **more: Any) -> Face:
        return Face(label or name, getattr(lf, name), lambda: {**_points(), **more})

    def pushed(name: str, **more: Any) -> Face:
        return Face(
            f"{name} in space", getattr(lf, name), lambda: {"P": _points()["P"], "value": (1.0, 0.0, 0.0), **more}
        )

    def scene() -> lf.SpatialScene:
        made = lf.SpatialScene()
        made.add(lf.Sphere(0.1, mass=1.0), name="ball")
        return made

    def placed() -> Any:
        return scene().body("ball")

    @cache
    def result() -> lf.Result:
        return lf.simulate(scene(), 0.003, lf.MoreauJean(step=1e-3), progress=False)

    def never() -> ContactHistory:
        return untouched("ball on floor", result().times, 4)

    def told(name: str, **arguments: Any) -> Face:
        return Face(f"Result.{name}", getattr(lf.Result, name), lambda: dict(arguments), result)

    return [
        Face("SpatialScene.join", _join, lambda: {"joint": None}),
        Face("SpatialScene.load", _load, lambda: {"load": None}),
        Face("SpatialScene.sensor", _sensor, lambda: {"sensor": None}),
        Face("SpatialScene.contact", _contact, dict),
        Face("SpatialScene.contact_all", lf.SpatialScene.contact_all, dict, lf.SpatialScene),
        Face(
            "SpatialScene.with_bodies",
            lf.SpatialScene.with_bodies,
            lambda: {"bodies": {"ball": lf.Sphere(0.1, mass=2.0)}},
            scene,
        ),
        Face("SpatialScene.revolute_with_clearance", _hinge_with_play, dict),
        Face("SpatialScene.contact of", _sides, lambda: {"a": None, "b": None}),
        Face("SpatialPlaced.plane", placed().plane, lambda: {"point": (0.0, 0.0, 0.0), "normal": axis}),
        Face("SpatialPlaced.sphere", placed().sphere, lambda: {"center": (0.0, 0.0, 0.0), "radius": 0.1}),
        Face("SpatialPlaced.hole", placed().hole, lambda: {"center": (0.0, 0.0, 0.0), "radius": 0.1}),
        Face("SpatialPlaced.rim", placed().rim, lambda: {"center": (0.0, 0.0, 0.0), "axis": axis, "radius": 0.1}),
        Face(
            "SpatialPlaced.capsule",
            placed().capsule,
            lambda: {"first": (0.0, 0.0, 0.0), "second": (0.0, 0.0, 1.0), "radius": 0.1},
        ),
        Face(
            "SpatialPlaced.cylinder",
            placed().cylinder,
            lambda: {"center": (0.0, 0.0, 0.0), "axis": axis, "radius": 0.1, "length": 0.2},
        ),
        Face("SpatialPlaced.box", placed().box, lambda: {"center": (0.0, 0.0, 0.0), "sizes": (0.1, 0.2, 0.3)}),
        Face("SpatialPlaced.hull", placed().hull, lambda: {"points": np.vstack([np.zeros(3), np.eye(3)])}),
        Face(
            "SpatialPlaced.face",
            lambda name: lf.SpatialScene().add(_solid(), modes=0).face(name),
            lambda: {"name": "left"},
        ),
        Face("SpatialPlaced.node", placed().node, lambda: {"point": (0.0, 0.0, 0.0)}),
        told("momentum", body="ball"),
        told("orientation", body="ball"),
        told("angular_velocity", body="ball", axes="body"),
        Face("ContactHistory.pressure", ContactHistory.pressure, lambda: {"t": 0.0}, never),
        Face("ContactHistory.plot_pressure", ContactHistory.plot_pressure, lambda: {"t": 0.0}, never),
        Face("SpatialScene", lf.SpatialScene, dict),
        Face("SpatialScene.add", lf.SpatialScene.add, lambda: {"body": lf.Sphere(0.1, mass=1.0)}, lf.SpatialScene),
        Face("SpatialScene.add flexible", lf.SpatialScene.add, lambda: {"body": _solid(), "modes": 2}, lf.SpatialScene),
        Face("SpatialScene.body", lf.SpatialScene.body, lambda: {"name": "ball"}, scene),
        Face("SpatialScene.compile", lf.SpatialScene.compile, dict, scene),
        part("Ball"),
        part("Universal", axis=axis, axis_p=(1.0, 0.0, 0.0)),
        part("Cylindrical", axis=axis),
        part("Planar", axis=axis),
        part("PointOnPlane", axis=axis),
        part("Bushing", stiffness=1.0),
        part("Revolute", "Revolute in space", axis=axis),
        part("Weld", "Weld in space"),
        part("Prismatic", "Prismatic in space", axis=axis),
        part("PointOnLine", "PointOnLine in space", axis=axis),
        part("DrivenAngle", "DrivenAngle in space", axis=axis, motion=0.0),
        part("DrivenDisplacement", "DrivenDisplacement in space", axis=axis, motion=0.0),
        part("TorsionSpring", "TorsionSpring in space", axis=axis, stiffness=1.0),
        pushed("Force"),
        pushed("Torque"),
    ]
