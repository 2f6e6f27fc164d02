"""Bodies, scenes and runs, and steppers."""

from __future__ import annotations

import inspect
import tempfile
from functools import cache
from pathlib import Path
from typing import Any

import scipy.io

import lcpflex as lf
from lcpflex.compile.compiled_scene import CompiledScene
from lcpflex.results.sensor import SensorHistory
from lcpflex.results.stress_history import StressHistory
from tests.property.fuzz.face import (
    Face,
    bar,
    beam,
    body,
    continuum,
    driven_scene,
    flexible_rest,
    flexible_result,
    followed,
    jointed_result,
    matrices,
    mesh,
    points,
    rest,
    resting_scene,
    result,
    small_scene,
    solid,
)
from tests.scenes import floor_of

__all__ = ["bodies_faces", "run_faces", "scene_faces", "sensor_faces"]


def _user_system() -> dict[str, Any]:
    return {
        "q": [1.0],
        "u": [0.0],
        "mass": [[1.0]],
        "force": lambda t, q, u: [-9.81],
        "gaps": lambda q: [q[0]],
        "normals": [[1.0]],
    }


def _kinematics() -> dict[str, Any]:
    return {"q": [1.0, 0.0], "kinematics": lambda q: [[1.0], [0.0]], "normalise": lambda q: q}


def _matrix(name: str) -> str:
    """The name of a file with a small matrix."""
    scipy.io.mmwrite(name, matrices()["mass" if name == "m.mtx" else "stiffness"])
    return name


def _slot(**changed: Any) -> lf.Slot:
    scene = lf.Scene()
    slot = scene.ground.straight_slot((0, 0), (0.05, 0), 0.02)
    sides = {name: getattr(slot, name) for name in ("inner", "outer", "first", "last")}
    return lf.Slot(**{**sides, "width": 0.02, **changed})


def _clearance(**changed: Any) -> str:
    scene = lf.Scene()
    a, b = (scene.add(lf.Disc(0.1, mass=1.0)).point("center") for _ in range(2))
    return scene.revolute_with_clearance(**{"P": a, "Q": b, "pin_radius": 0.01, "hole_radius": 0.011, **changed})


_slot.__signature__ = inspect.signature(lf.Slot)  # type: ignore[attr-defined]
_clearance.__signature__ = inspect.Signature(  # type: ignore[attr-defined]
    list(inspect.signature(lf.Scene.revolute_with_clearance).parameters.values())[1:]
)


@cache
def _checkpoint() -> bytes:
    """What is in the file of a short run."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "run.npz"
        lf.simulate(small_scene(), 0.01, lf.MoreauJean(step=1e-3), progress=False, checkpoint=path, every=1e-9)
        return path.read_bytes()


def _resumed() -> dict[str, Any]:
    Path("run.npz").write_bytes(_checkpoint())
    return {"path": "run.npz", "progress": False}


def bodies_faces() -> list[Face]:
    def named(name: str, **arguments: Any) -> Face:
        return Face(name, getattr(lf, name), lambda: dict(arguments))

    reduce = {"modes": 2}
    return [
        named("RigidBody", mass=1.0, inertia=0.1, center=(0.0, 0.0), points={"a": (0.1, 0.0)}),
        named("Disc", radius=0.1, mass=1.0),
        Face("Disc of density", lf.Disc, lambda: {"radius": 0.1, "density": 7800.0}),
        named("Box", width=0.1, height=0.2, mass=1.0),
        named("Polygon", vertices=[(0, 0), (1, 0), (0, 1)], mass=1.0),
        named("Beam", length=0.7, width=0.028, thickness=0.005, density=2700.0, youngs_modulus=6.9e10),
        named("Bar", length=1.0, area=1e-4, density=7800.0, youngs_modulus=2e11),
        named("Rayleigh", alpha=0.1, beta=1e-5),
        named("Interface", place="left"),
        named("Stiffening", held="left"),
        Face(
            "Continuum",
            lf.Continuum,
            lambda: {"mesh": mesh(), "density": 7800.0, "youngs_modulus": 2e11, "poissons_ratio": 0.3},
        ),
        Face(
            "SolidOfRevolution",
            lf.SolidOfRevolution,
            lambda: {"mesh": mesh(), "density": 7800.0, "youngs_modulus": 2e11, "poissons_ratio": 0.3},
        ),
        Face("Matrices", lf.Matrices, matrices),
        Face("Beam.reduce", lf.Beam.reduce, lambda: dict(reduce), beam),
        Face("Bar.reduce", lf.Bar.reduce, lambda: dict(reduce), bar),
        Face("Continuum.reduce", lf.Continuum.reduce, lambda: dict(reduce), continuum),
        Face("SolidOfRevolution.reduce", lf.SolidOfRevolution.reduce, lambda: dict(reduce), solid),
        Face("Matrices.reduce", lf.Matrices.reduce, lambda: {"modes": 1}, lambda: lf.Matrices(**matrices())),
        Face("craig_bampton", lf.craig_bampton, lambda: {"model": continuum(), "boundary": "left", "modes": 2}),
        Face("free_interface", lf.free_interface, lambda: {"model": continuum(), "modes": 2}),
        Face(
            "residual_compliance",
            lf.residual_compliance,
            lambda: {"model": continuum(), "contact": "left", "modes": 2},
        ),
        Face("sub_regional", lf.sub_regional, lambda: {"model": continuum(), "region": "left"}),
        Face("unreduced", lf.unreduced, lambda: {"model": continuum()}),
        Face(
            "matrices_from_files",
            lf.matrices_from_files,
            lambda: {"mass": _matrix("m.mtx"), "stiffness": _matrix("k.mtx"), "coordinates": matrices()["coordinates"]},
        ),
    ]


def scene_faces() -> list[Face]:
    def joint(name: str, **more: Any) -> Face:
        return Face(name, getattr(lf, name), lambda: {**points(), **more})

    def surfaces() -> tuple[lf.Scene, Any, Any]:
        scene = lf.Scene()
        disc = scene.add(lf.Disc(0.1, mass=1.0), name="disc", position=(0.0, 0.5))
        return scene, disc.surface(), floor_of(scene)

    def contact(**changed: Any) -> Any:
        scene, a, b = surfaces()
        return scene.contact(**{"a": a, "b": b, **changed})

    contact.__signature__ = inspect.Signature(  # type: ignore[attr-defined]
        list(inspect.signature(lf.Scene.contact).parameters.values())[1:]
    )

    def join(joint: Any) -> Any:
        return small_scene().join(joint)

    def load(load: Any) -> Any:
        return small_scene().load(load)

    def placed(method: str, **arguments: Any) -> Face:
        kind = type(body())
        return Face(f"handle.{method}", getattr(kind, method), lambda: dict(arguments), body)

    def pin(**changed: Any) -> Any:
        scene = lf.Scene()
        a, b = (scene.add(lf.Disc(0.1, mass=1.0)) for _ in range(2))
        slot = b.straight_slot((0, 0), (0.05, 0), 0.02)
        return scene.contact_slot(**{"slot": slot, "pin": a.circle((0, 0), 0.009), **changed})

    pin.__signature__ = inspect.Signature(  # type: ignore[attr-defined]
        list(inspect.signature(lf.Scene.contact_slot).parameters.values())[1:]
    )
    return [
        Face("Scene", lf.Scene, dict),
        Face("Scene.add", lf.Scene.add, lambda: {"body": lf.Disc(0.1, mass=1.0)}, lf.Scene),
        Face("Scene.add flexible", lf.Scene.add, lambda: {"body": beam(), "modes": 2}, lf.Scene),
        Face("Scene.body", lf.Scene.body, lambda: {"name": "disc"}, small_scene),
        Face("Scene.join", join, lambda: {"joint": None}),
        Face("Scene.load", load, lambda: {"load": None}),
        Face("Scene.contact", contact, dict),
        Face("Scene.contact_slot", pin, dict),
        Face("Slot", _slot, dict),
        Face("Scene.revolute_with_clearance", _clearance, dict),
        Face("Scene.contact_all", lf.Scene.contact_all, dict, small_scene),
        Face(
            "Scene.with_bodies", lf.Scene.with_bodies, lambda: {"bodies": {"disc": lf.Disc(0.1, mass=2.0)}}, small_scene
        ),
        Face("Scene.compile", lf.Scene.compile, dict, small_scene),
        Face("CompiledScene.at", CompiledScene.at, dict, lambda: small_scene().compile()),
        Face(
            "StateMechanics.contact_problem",
            lf.StateMechanics.contact_problem,
            lambda: {"level": "impulse"},
            lambda: small_scene().compile().at(),
        ),
        Face(
            "StateMechanics.velocity_rows",
            lf.StateMechanics.velocity_rows,
            lambda: {"body": "disc"},
            lambda: small_scene().compile().at(),
        ),
        placed("point", name="center"),
        placed("at", x=0.0, y=0.0),
        placed("surface", name="outline"),
        placed("circle", center="center", radius=0.1),
        placed("hole", center="center", radius=0.1),
        placed("arc", center=(0.0, 0.0), radius=0.1, start=0.0, extent=1.0),
        placed("node", x=0.0, y=0.0),
        placed("half_plane", point=(0.0, 0.0), normal=(0.0, 1.0)),
        placed("chain", places=[(0.0, 0.0), (1.0, 0.0)]),
        placed("curved_slot", center=(0.0, 0.0), radius=0.1, width=0.02, start=0.0, extent=1.0),
        placed("straight_slot", first=(0.0, 0.0), last=(0.1, 0.0), width=0.02),
        joint("Revolute"),
        joint("Weld"),
        joint("Prismatic"),
        joint("PointOnLine"),
        joint("Distance"),
        joint("DrivenAngle", motion=0.0),
        joint("DrivenDisplacement", axis=(1.0, 0.0), motion=0.0),
        joint("Spring", stiffness=1.0),
        joint("TorsionSpring", stiffness=1.0),
        Face("Force", lf.Force, lambda: {"P": points()["P"], "value": (1.0, 0.0)}),
        Face("Torque", lf.Torque, lambda: {"P": points()["P"], "value": 1.0}),
        Face("Harmonic", lf.Harmonic, lambda: {"amplitude": 1.0, "omega": 1.0}),
        Face("Table", lf.Table, lambda: {"times": [0.0, 1.0], "values": [0.0, 1.0]}),
        Face("Function", lf.Function, lambda: {"function": lambda t: t}),
        Face("UserSystem", lf.UserSystem, _user_system),
        Face("UserSystem with kinematics", lf.UserSystem, lambda: {**_user_system(), **_kinematics()}),
    ]


def sensor_faces() -> list[Face]:
    def sensor(sensor: Any) -> Any:
        return small_scene().sensor(sensor)

    @cache
    def measured() -> lf.Result:
        scene = small_scene()
        scene.sensor(lf.sensors.Energy(name="energy"))
        return lf.simulate(scene, 0.005, lf.MoreauJean(step=1e-3), progress=False)

    kinds: dict[str, dict[str, Any]] = {
        "Body": {"body": "disc"},
        "Coordinates": {"names": ("disc.x",)},
        "Energy": {},
        "Reaction": {"joint": "hinge"},
        "Contact": {"contact": "floor"},
        "Section": {"body": "beam", "x": 0.1},
        "Stress": {"body": "beam", "place": (0.1, 0.0)},
        "Function": {"function": lambda now: now.time},
    }
    return [
        Face("Scene.sensor", sensor, lambda: {"sensor": lf.sensors.Energy()}),
        Face("Result.sensor", lf.Result.sensor, lambda: {"name": "energy"}, measured),
        Face(
            "SensorHistory.column",
            SensorHistory.column,
            lambda: {"name": "kinetic"},
            lambda: measured().sensor("energy"),
        ),
        Face("Point", lf.sensors.Point, lambda: {"P": points()["P"]}),
        *(Face(name, getattr(lf.sensors, name), lambda given=given: dict(given)) for name, given in kinds.items()),
    ]


def run_faces() -> list[Face]:
    run = {"duration": 0.005, "stepper": lf.MoreauJean(step=1e-3), "progress": False}
    of_result = [
        ("contact", {"name": "floor"}),
        ("point", {"body": "disc", "point": "center"}),
        ("velocity", {"body": "disc", "point": "center"}),
        ("draw", {"t": 0.0, "frames": False, "scale": 1.0, "pressure": False}),
        ("save", {"path": "unused.npz"}),
        ("to_vtkhdf", {"path": "unused.vtkhdf", "stress": False, "every": 2}),
        ("modes_of", {"body": "disc"}),
        ("at", {"t": 0.0015, "before": True}),
        ("angle", {"body": "disc", "relative_to": "box"}),
        (
            "animate",
            {"path": "film.gif", "fps": 1.0, "slowdown": 100.0, "frames": False, "scale": 1.0, "pressure": False},
        ),
    ]
    of_rest = [
        ("contact", {"name": "floor"}),
        ("joint", {"name": "hinge"}),
        ("point", {"body": "disc", "point": "center"}),
        ("summary", {}),
        ("draw", {"frames": False, "scale": 1.0}),
    ]
    of_path = [
        ("contact", {"name": "floor"}),
        ("joint", {"name": "lift"}),
        ("point", {"body": "disc", "point": "center"}),
        ("plot", {}),
    ]
    settled = lf.Scene(gravity=(0.0, 0.0))
    settled.add(lf.Disc(0.1, mass=1.0), name="disc")
    steppers = {
        "MoreauJean": {"step": 1e-3},
        "GeneralizedAlpha": {"step": 1e-3},
        "EventDriven": {},
        "MasslessBoundary": {},
        "AdaptiveStep": {},
        "ExplicitRungeKutta": {},
        "Stiff": {},
        "Verlet": {"step": 1e-3},
        "Newton": {},
        "Poisson": {},
        "Stronge": {},
        "Penalty": {"stiffness": 1e5},
        "Smooth": {"law": lf.Penalty(1e5)},
        "RecordProblems": {"path": "problems.npz"},
    }
    return [
        Face("simulate", lf.simulate, lambda: {"scene": small_scene(), **run}),
        Face("equilibrium", lf.equilibrium, lambda: {"scene": resting_scene()}),
        Face(
            "path",
            lf.path,
            lambda: {"scene": driven_scene(), "drive": "lift", "values": (0.5, 0.51), "progress": False},
        ),
        *(
            Face(
                f"EquilibriumPath.{name}", getattr(lf.EquilibriumPath, name), lambda given=given: dict(given), followed
            )
            for name, given in of_path
        ),
        Face("equilibria", lf.equilibria, lambda: {"scene": resting_scene(), "bodies": (), "reach": 0.1}),
        *(
            Face(f"Rest.{name}", getattr(lf.Rest, name), lambda given=given: dict(given), rest)
            for name, given in of_rest
        ),
        Face("Rest.stress", lf.Rest.stress, lambda: {"body": "plate"}, flexible_rest),
        Face("admissible_accelerations", lf.admissible_accelerations, lambda: {"scene": settled}),
        Face("resume", lf.resume, _resumed),
        Face("Result.reaction", lf.Result.reaction, lambda: {"joint": "hinge", "axes": "body"}, jointed_result),
        Face("Result.verify", lf.Result.verify, lambda: {"other": False}, result),
        Face("Result.section", lf.Result.section, lambda: {"body": "beam"}, flexible_result),
        Face("Result.deflection", lf.Result.deflection, lambda: {"body": "beam", "point": "left"}, flexible_result),
        Face("Result.stress", lf.Result.stress, lambda: {"body": "plate"}, flexible_result),
        Face("StressHistory.at", StressHistory.at, lambda: {"t": 0.0}, lambda: flexible_result().stress("plate")),
        Face("StressHistory.of", StressHistory.of, lambda: {"record": 0}, lambda: flexible_result().stress("plate")),
        Face("Result.load", lf.Result.load, lambda: {"path": "unused.npz"}),
        *(
            Face(f"Result.{name}", getattr(lf.Result, name), lambda given=given: dict(given), result)
            for name, given in of_result
        ),
        *(Face(name, getattr(lf, name), lambda given=given: dict(given)) for name, given in steppers.items()),
    ]
