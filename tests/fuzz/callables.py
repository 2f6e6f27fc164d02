"""The public face of lcpflex: what can be called, with arguments that it takes."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

import lcpflex as lf
from lcpflex import advice, gallery, laws, meshes, solvers, studies

__all__ = ["Face", "OUTPUTS", "faces"]

# Made by the library and handed out: users read them.
OUTPUTS = {
    "Result",
    "Solution",
    "Replay",
    "CrossCheck",
    "FidelityRun",
    "NextRung",
    "RightSize",
    "StabilityMap",
    "Vibrations",
    "WorkPoint",
    "WorkPrecision",
    "Verdict",
    "SlotParts",
    "PowerFit",
    "Case",
    "ContactAdvice",
}
# Exceptions, enumerations, protocols, functions without arguments.
PLAIN = {
    "LcpflexError",
    "ModelError",
    "ModelWarning",
    "SolverError",
    "StepError",
    "EnergyGrowth",
    "Status",
    "Outcome",
    "HysteresisFactor",
    "HasMesh",
    "HasModes",
    "scenes",
    "warmup_cases",
    "__version__",
    "PAIRS",
    "PER_WAVELENGTH",
}


class Face(NamedTuple):
    """A callable and arguments that it takes, made anew for each call."""

    name: str
    function: Callable[..., Any]
    arguments: Callable[[], dict[str, Any]]
    bound: Callable[[], Any] | None = None  # makes the object whose method it is; then ``function`` takes it first

    def parameters(self) -> list[str]:
        """Every argument by name."""
        signature = inspect.signature(self.function)
        kinds = (inspect.Parameter.POSITIONAL_OR_KEYWORD, inspect.Parameter.KEYWORD_ONLY)
        names = [name for name, parameter in signature.parameters.items() if parameter.kind in kinds]
        return names[1:] if self.bound is not None else names

    def call(self, **changed: Any) -> Any:
        """Call it with its arguments, but for those that are changed."""
        arguments = {**self.arguments(), **changed}
        if self.bound is not None:
            return self.function(self.bound(), **arguments)
        return self.function(**arguments)


def _scene() -> lf.Scene:
    scene = lf.Scene()
    disc = scene.add(lf.Disc(0.1, mass=1.0), name="disc", position=(0.0, 0.5))
    scene.add(lf.Box(0.2, 0.1, mass=1.0), name="box", position=(1.0, 0.5))
    scene.contact(disc.surface(), scene.ground.half_plane((0, 0), (0, 1)), name="floor", friction=0.3)
    return scene


def _body(name: str = "disc") -> Any:
    return _scene().body(name)


@cache
def result() -> lf.Result:
    """A short run."""
    return lf.simulate(_scene(), 0.01, lf.MoreauJean(step=1e-3), progress=False)


def _points() -> dict[str, Any]:
    scene = _scene()
    return {"P": scene.body("disc").point("center"), "Q": scene.ground.at(0.0, 0.0)}


def _contact() -> solvers.ContactProblem:
    return solvers.ContactProblem(np.eye(3) * 2.0, [-1.0, -1.0, 0.1], [0.0, 0.3])


def _lcp() -> solvers.Lcp:
    return solvers.Lcp([[2.0, 1.0], [1.0, 2.0]], [-1.0, -1.0])


def _boxed() -> solvers.BoxedLcp:
    return solvers.BoxedLcp(np.eye(2), [-1.0, 1.0], [0.0, -1.0], [1.0, 1.0])


def _mixed() -> solvers.MixedLcp:
    return solvers.MixedLcp(np.eye(2), [-1.0, 1.0], [0])


def _steel() -> laws.Material:
    return laws.Material(2e11, 0.3)


def _pair() -> laws.CylinderPair:
    return laws.CylinderPair.internal(0.0105, 0.01, 0.02, _steel())


def _beam() -> lf.Beam:
    return lf.Beam(0.7, 0.028, 0.005, 2700.0, 6.9e10, elements=6)


def _bar() -> lf.Bar:
    return lf.Bar(1.0, 1e-4, 7800.0, 2e11, elements=6)


@cache
def _mesh() -> Any:
    return meshes.rectangle(0.4, 0.1, 4, 2)


def _continuum() -> lf.Continuum:
    return lf.Continuum(_mesh(), 7800.0, 2e11, 0.3)


def _solid() -> lf.SolidOfRevolution:
    return lf.SolidOfRevolution(_mesh(), 7800.0, 2e11, 0.3)


def _matrices() -> dict[str, Any]:
    elements = _continuum().finite_elements()
    return {"mass": elements.mass, "stiffness": elements.stiffness, "coordinates": elements.places}


def _user_system() -> dict[str, Any]:
    return {
        "q": [1.0],
        "u": [0.0],
        "mass": [[1.0]],
        "force": lambda t, q, u: [-9.81],
        "gaps": lambda q: [q[0]],
        "normals": [[1.0]],
    }


def _case() -> Any:
    return gallery.scenes()["bouncing_ball"]


@cache
def _map() -> studies.StabilityMap:
    return studies.stability(_case(), {"a": lf.MoreauJean(step=1e-2)}, {"height": [0.1, 0.2]}, 0.02, progress=False)


@cache
def _work() -> studies.WorkPrecision:
    series = (lf.MoreauJean(step=4e-3), lf.MoreauJean(step=2e-3), lf.MoreauJean(step=1e-3))
    return studies.work_precision(_case(), {"a": series}, duration=0.05, repeats=0, progress=False)


def _work_arguments() -> dict[str, Any]:
    series = (lf.MoreauJean(step=4e-3), lf.MoreauJean(step=2e-3))
    return {"scenes": _case(), "methods": {"a": series}, "duration": 0.02, "repeats": 0, "progress": False}


def _bodies_faces() -> list[Face]:
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
            lambda: {"mesh": _mesh(), "density": 7800.0, "youngs_modulus": 2e11, "poissons_ratio": 0.3},
        ),
        Face(
            "SolidOfRevolution",
            lf.SolidOfRevolution,
            lambda: {"mesh": _mesh(), "density": 7800.0, "youngs_modulus": 2e11, "poissons_ratio": 0.3},
        ),
        Face("Matrices", lf.Matrices, _matrices),
        Face("Beam.reduce", lf.Beam.reduce, lambda: dict(reduce), _beam),
        Face("Bar.reduce", lf.Bar.reduce, lambda: dict(reduce), _bar),
        Face("Continuum.reduce", lf.Continuum.reduce, lambda: dict(reduce), _continuum),
        Face("SolidOfRevolution.reduce", lf.SolidOfRevolution.reduce, lambda: dict(reduce), _solid),
        Face("Matrices.reduce", lf.Matrices.reduce, lambda: {"modes": 1}, lambda: lf.Matrices(**_matrices())),
        Face("craig_bampton", lf.craig_bampton, lambda: {"model": _continuum(), "boundary": "left", "modes": 2}),
        Face("free_interface", lf.free_interface, lambda: {"model": _continuum(), "modes": 2}),
        Face(
            "residual_compliance",
            lf.residual_compliance,
            lambda: {"model": _continuum(), "contact": "left", "modes": 2},
        ),
        Face("sub_regional", lf.sub_regional, lambda: {"model": _continuum(), "region": "left"}),
        Face("unreduced", lf.unreduced, lambda: {"model": _continuum()}),
        Face(
            "matrices_from_files",
            lf.matrices_from_files,
            lambda: {"mass": "m.mtx", "stiffness": "k.mtx", "coordinates": [(0.0, 0.0)]},
        ),
    ]


def _scene_faces() -> list[Face]:
    def joint(name: str, **more: Any) -> Face:
        return Face(name, getattr(lf, name), lambda: {**_points(), **more})

    def surfaces() -> tuple[lf.Scene, Any, Any]:
        scene = lf.Scene()
        disc = scene.add(lf.Disc(0.1, mass=1.0), name="disc", position=(0.0, 0.5))
        return scene, disc.surface(), scene.ground.half_plane((0, 0), (0, 1))

    def contact(**changed: Any) -> Any:
        scene, a, b = surfaces()
        return scene.contact(**{"a": a, "b": b, **changed})

    contact.__signature__ = inspect.Signature(  # type: ignore[attr-defined]
        list(inspect.signature(lf.Scene.contact).parameters.values())[1:]
    )

    def join(joint: Any) -> Any:
        return _scene().join(joint)

    def load(load: Any) -> Any:
        return _scene().load(load)

    def placed(method: str, **arguments: Any) -> Face:
        kind = type(_body())
        return Face(f"handle.{method}", getattr(kind, method), lambda: dict(arguments), _body)

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
        Face("Scene.add flexible", lf.Scene.add, lambda: {"body": _beam(), "modes": 2}, lf.Scene),
        Face("Scene.body", lf.Scene.body, lambda: {"name": "disc"}, _scene),
        Face("Scene.join", join, lambda: {"joint": None}),
        Face("Scene.load", load, lambda: {"load": None}),
        Face("Scene.contact", contact, dict),
        Face("Scene.contact_slot", pin, dict),
        Face("Scene.contact_all", lf.Scene.contact_all, dict, _scene),
        Face("Scene.with_bodies", lf.Scene.with_bodies, lambda: {"bodies": {"disc": lf.Disc(0.1, mass=2.0)}}, _scene),
        Face("Scene.compile", lf.Scene.compile, dict, _scene),
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
        Face("Force", lf.Force, lambda: {"P": _points()["P"], "value": (1.0, 0.0)}),
        Face("Torque", lf.Torque, lambda: {"P": _points()["P"], "value": 1.0}),
        Face("Harmonic", lf.Harmonic, lambda: {"amplitude": 1.0, "omega": 1.0}),
        Face("Table", lf.Table, lambda: {"times": [0.0, 1.0], "values": [0.0, 1.0]}),
        Face("Function", lf.Function, lambda: {"function": lambda t: t}),
        Face("UserSystem", lf.UserSystem, _user_system),
    ]


def _run_faces() -> list[Face]:
    run = {"duration": 0.005, "stepper": lf.MoreauJean(step=1e-3), "progress": False}
    of_result = [
        ("contact", {"name": "floor"}),
        ("point", {"body": "disc", "point": "center"}),
        ("velocity", {"body": "disc", "point": "center"}),
        ("draw", {"t": 0.0}),
        ("save", {"path": "unused.npz"}),
        ("modes_of", {"body": "disc"}),
        ("animate", {"path": "film.gif", "fps": 1.0, "slowdown": 100.0}),
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
        "Energetic": {},
        "Penalty": {"stiffness": 1e5},
        "Smooth": {"law": lf.Penalty(1e5)},
        "RecordProblems": {"path": "problems.npz"},
    }
    return [
        Face("simulate", lf.simulate, lambda: {"scene": _scene(), **run}),
        Face("admissible_accelerations", lf.admissible_accelerations, lambda: {"scene": settled}),
        Face("Result.load", lf.Result.load, lambda: {"path": "unused.npz"}),
        *(
            Face(f"Result.{name}", getattr(lf.Result, name), lambda given=given: dict(given), result)
            for name, given in of_result
        ),
        *(Face(name, getattr(lf, name), lambda given=given: dict(given)) for name, given in steppers.items()),
    ]


def _solver_faces() -> list[Face]:
    kinds = {"": _lcp, " of contact": _contact, " boxed": _boxed, " mixed": _mixed}
    out: list[Face] = [
        Face("Lcp", solvers.Lcp, lambda: {"M": np.eye(2), "q": [-1.0, 1.0]}),
        Face(
            "BoxedLcp", solvers.BoxedLcp, lambda: {"M": np.eye(2), "q": [-1.0, 1.0], "lower": 0.0, "upper": [1.0, 2.0]}
        ),
        Face("MixedLcp", solvers.MixedLcp, lambda: {"M": np.eye(2), "q": [-1.0, 1.0], "free": [0]}),
        Face(
            "ContactProblem",
            solvers.ContactProblem,
            lambda: {"delassus": np.eye(3), "free": [-1.0, -1.0, 0.1], "friction": [0.0, 0.3]},
        ),
        Face(
            "SpatialContactProblem",
            solvers.SpatialContactProblem,
            lambda: {"delassus": np.eye(3), "free": [-1.0, 0.0, 0.1], "friction": [0.3]},
        ),
        Face(
            "SpatialContactProblem.residual",
            solvers.SpatialContactProblem.residual,
            lambda: {"forces": [1.0, 0.0, 0.0]},
            lambda: solvers.SpatialContactProblem(np.eye(3), [-1.0, 0.0, 0.1], [0.3]),
        ),
        Face("accept", solvers.accept, lambda: {"problem": _lcp(), "z": [0.0, 0.0], "tolerance": 1e-10}),
        Face("solve_lcp", solvers.solve_lcp, lambda: {"M": np.eye(2), "q": [-1.0, 1.0]}),
        Face(
            "cross_check",
            solvers.cross_check,
            lambda: {"problem": _lcp(), "solvers": {"Lemke": solvers.Lemke()}, "repeats": 1},
        ),
        Face("all_solvers", solvers.all_solvers, dict),
        Face("save_problems", solvers.save_problems, lambda: {"path": "problems.npz", "problems": [_lcp()]}),
        *(
            Face(name, getattr(solvers, name), lambda: {"path": "unused"})
            for name in ("load_problems", "load_text_lcp", "load_fclib")
        ),
        Face(
            "replay",
            solvers.replay,
            lambda: {"problems": [_lcp()], "solvers": {"Lemke": solvers.Lemke()}, "repeats": 1},
        ),
    ]
    for name in (
        "Auto",
        "BlockGaussSeidel",
        "ConvexFriction",
        "Enumeration",
        "GaussSeidel",
        "Lemke",
        "MinMapNewton",
        "PrincipalPivoting",
        "QuadraticProgram",
    ):
        kind = getattr(solvers, name)
        problem = _contact if name == "ConvexFriction" else _lcp
        out += [
            Face(name, kind, dict),
            Face(f"{name}.solve", kind.solve, lambda problem=problem: {"problem": problem()}, kind),
            Face(f"{name}.refuses", kind.refuses, lambda problem=problem: {"problem": problem()}, kind),
        ]
    for label, make in kinds.items():
        kind = type(make())
        points: dict[str, dict[str, Any]] = {
            "slack": {"z": np.zeros(make().size)},
            "residual": {"z": np.zeros(make().size)},
        }
        if label != "":
            points["solve_by"] = {"solver": solvers.Lemke()}
        if label == " of contact":
            points |= {
                "forces": {"z": np.zeros(4)},
                "velocity": {"forces": np.zeros(3)},
                "unknowns": {"lambda_normal": np.zeros(2), "lambda_tangent": np.zeros(1)},
            }
        elif label:
            points["recover"] = {"x": np.zeros(make().lcp().size)}
        out += [
            Face(f"{kind.__name__}.{name}", getattr(kind, name), lambda given=given: dict(given), make)
            for name, given in points.items()
        ]
    return out


def _law_faces() -> list[Face]:
    pair_laws = (
        "DubowskyFreudenstein",
        "Esdu78035",
        "Goldsmith",
        "Johnson",
        "LankaraniNikraveshCylinder",
        "Liu",
        "Pereira",
        "Persson",
        "Radzimovsky",
    )
    frictions = (
        "Ambrosio",
        "ArctangentCoulomb",
        "BengisuAkay",
        "BrownMcPhee",
        "RampCoulomb",
        "SmoothedCoulomb",
        "Threlfall",
    )
    rubbing = {"slip": 0.1, "normal": 1.0, "mu": 0.3}
    elastic = {
        "PowerLaw": lambda: laws.PowerLaw(1e9),
        "Hertz": lambda: laws.Hertz(0.01, 1e11, 0.01),
        "Persson": lambda: laws.Persson(_pair()),
        "Johnson": lambda: laws.Johnson(_pair()),
    }
    out = [
        Face("Material", laws.Material, lambda: {"youngs_modulus": 2e11, "poissons_ratio": 0.3}),
        Face("PowerLaw", laws.PowerLaw, lambda: {"stiffness": 1e9}),
        Face("Hertz", laws.Hertz, lambda: {"effective_radius": 0.01, "contact_modulus": 1e11, "smallest_radius": 0.01}),
        Face("Hertz.spheres", laws.Hertz.spheres, lambda: {"radius": 0.01, "other_radius": 0.02, "material": _steel()}),
        Face("Hertz.sphere_on_plane", laws.Hertz.sphere_on_plane, lambda: {"radius": 0.01, "material": _steel()}),
        Face(
            "Hertz.sphere_in_cup",
            laws.Hertz.sphere_in_cup,
            lambda: {"radius": 0.01, "cup_radius": 0.02, "material": _steel()},
        ),
        Face(
            "Hertz.between",
            laws.Hertz.between,
            lambda: {"a": _body().surface(), "b": _body("box").circle((0, 0), 0.1), "material": _steel()},
        ),
        Face(
            "CylinderPair.internal",
            laws.CylinderPair.internal,
            lambda: {"hole_radius": 0.011, "pin_radius": 0.01, "length": 0.1, "material": _steel()},
        ),
        Face(
            "CylinderPair.external",
            laws.CylinderPair.external,
            lambda: {"radius": 0.011, "other_radius": 0.01, "length": 0.1, "material": _steel()},
        ),
        Face(
            "CylinderPair.between",
            laws.CylinderPair.between,
            lambda: {"a": _body().surface(), "b": _body().hole((0, 0), 0.11), "length": 0.1, "material": _steel()},
        ),
        Face("ContactLaw", laws.ContactLaw, lambda: {"elastic": laws.PowerLaw(1e9)}),
        Face("HysteresisDamping", laws.HysteresisDamping, lambda: {"restitution": 0.5}),
        Face(
            "HysteresisFactor.eta",
            laws.HysteresisFactor.eta,
            lambda: {"restitution": 0.5},
            lambda: laws.HysteresisFactor.EXACT,
        ),
        Face(
            "HysteresisFactor.rebound",
            laws.HysteresisFactor.rebound,
            lambda: {"restitution": 0.5},
            lambda: laws.HysteresisFactor.EXACT,
        ),
        *(
            Face(name, getattr(laws, name), lambda: {"restitution": 0.5})
            for name in ("Jankowski", "KelvinVoigt", "Tsuji", "PermanentIndentation")
        ),
        *(
            Face(f"{name}.rebound", getattr(laws, name).rebound, lambda: {"restitution": 0.5})
            for name in ("Jankowski", "KelvinVoigt", "Tsuji", "PermanentIndentation")
        ),
        *(
            Face(f"{name}.rebound", getattr(laws, name).rebound, lambda: {"parameter": 0.5})
            for name in ("KuwabaraKono", "Ristow")
        ),
        Face("KuwabaraKono", laws.KuwabaraKono, lambda: {"relaxation": 1e-6}),
        Face("Ristow", laws.Ristow, lambda: {"rate": 1.0}),
        *(Face(name, getattr(laws, name), lambda: {"pair": _pair()}) for name in pair_laws),
        *(Face(name, getattr(laws, name), dict) for name in (*frictions, "LuGre", "Bristle")),
        *(
            Face(f"{name}.force", getattr(laws, name).force, lambda: dict(rubbing), getattr(laws, name))
            for name in frictions
        ),
        Face("LuGre.steady_force", laws.LuGre.steady_force, lambda: dict(rubbing), laws.LuGre),
        Face("Persson.force_at_angle", laws.Persson.force_at_angle, lambda: {"eps": 0.5}, elastic["Persson"]),
        Face("OwnLaw", laws.OwnLaw, lambda: {"function": lambda d, v, v0, p: 1e6 * d, "compiled": False}),
        Face(
            "OwnLaw.force",
            laws.OwnLaw.force,
            lambda: {"delta": 1e-6},
            lambda: laws.OwnLaw(lambda d, v, v0, p: 1e6 * d, compiled=False),
        ),
        Face(
            "fit_power_law",
            laws.fit_power_law,
            lambda: {"law": laws.PowerLaw(1e9), "load_range": (1.0, 100.0), "points": 10},
        ),
        Face("prescribed_restitution", laws.prescribed_restitution, lambda: {"law": laws.KelvinVoigt, "e_out": 0.5}),
        Face("restitution_of", laws.restitution_of, lambda: {"law": laws.Jankowski, "e": 0.5}),
    ]
    for name, make in elastic.items():
        kind = type(make())
        for method in ("force", "stiffness_at", "stiffness", "energy", "indentation"):
            if callable(getattr(kind, method, None)):
                argument = list(inspect.signature(getattr(kind, method)).parameters)[1]
                out.append(
                    Face(f"{name}.{method}", getattr(kind, method), lambda argument=argument: {argument: 1e-6}, make)
                )
    return out


def _mesh_faces() -> list[Face]:
    def face(name: str, **arguments: Any) -> Face:
        return Face(f"meshes.{name}", getattr(meshes, name), lambda: dict(arguments))

    return [
        face("rectangle", length=1.0, height=1.0, nx=2, ny=2),
        face("bar", length=1.0, height=0.1, elements=2),
        face("grid", x=[0.0, 1.0], y=[0.0, 1.0]),
        face("ring", inner=1.0, outer=2.0, around=8, through=1),
        face("half_disc", radius=1.0, size=0.5),
        face("half_section_of_sphere", radius=1.0, size=0.5),
        face("half_section_of_rod", length=1.0, radius=0.5, size=0.5),
        Face("meshes.quadratic", meshes.quadratic, lambda: {"mesh": _mesh()}),
        Face(
            "meshes.graded",
            meshes.graded,
            lambda: {"mesh": meshes.rectangle(1.0, 1.0, 2, 2, triangles=True), "towards": (0.0, 0.0), "finest": 0.2},
        ),
    ]


def _advice_faces() -> list[Face]:
    def face(name: str, **arguments: Any) -> Face:
        return Face(f"advice.{name}", getattr(advice, name), lambda: dict(arguments))

    def advised(
        mass: Any,
        radius: Any,
        modulus: Any,
        speed: Any,
        wave_speed: Any,
        half_section: Any = False,
        fraction: Any = 0.1,
    ) -> Any:
        return advice.contact_advice(
            mass, radius, modulus, speed, wave_speed, half_section=half_section, fraction=fraction
        )

    return [
        face("wave_speed", youngs_modulus=2e11, density=7800.0),
        face("element_size", frequency=1e4, wave_speed=5e3),
        face("effective", first=1.0, second=2.0),
        face("effective_modulus", first=(2e11, 0.3)),
        face("contact_time", mass=1.0, radius=0.01, modulus=1e11, speed=1.0),
        face("excited_frequency", contact_time=1e-4),
        face("contact_radius", force=10.0, radius=0.01, modulus=1e11),
        face("contact_pairs", contact_radius=1e-3, element_size=1e-4),
        Face(
            "advice.contact_advice",
            advised,
            lambda: {"mass": 1.0, "radius": 0.01, "modulus": 1e11, "speed": 1.0, "wave_speed": 5e3},
        ),
        Face("advice.modes_needed", advice.modes_needed, lambda: {"body": _beam(), "frequency": 1e3}),
    ]


def _gallery_faces() -> list[Face]:
    small: dict[str, dict[str, Any]] = {
        "meshed_ball": {"finest": 1e-3, "modes": 2},
        "meshed_rod": {"finest": 2e-3, "modes": 2},
        "painleve_friction": {"degrees": 60.0},
    }

    def face(name: str) -> Face:
        return Face(f"gallery.{name}", getattr(gallery, name), lambda: dict(small.get(name, {})))

    return [face(name) for name in gallery.__all__ if name not in PLAIN | OUTPUTS]


def _study_faces() -> list[Face]:
    t = np.array([0.0, 1.0, 2.0])
    stability = {
        "methods": {"a": lf.MoreauJean(step=1e-2)},
        "axes": {"height": [0.1]},
        "duration": 0.02,
        "progress": False,
    }
    return [
        Face("Criteria", studies.Criteria, dict),
        Face("Output", studies.Output, lambda: {"name": "x", "function": lambda result: 1.0}),
        Face(
            "graph_distance",
            studies.graph_distance,
            lambda: {"times": t, "values": t, "other_times": t, "other_values": t + 1},
        ),
        Face(
            "small_vibrations", studies.small_vibrations, lambda: {"scene": gallery.scenes()["double_pendulum"].build()}
        ),
        Face("acceleration_level", studies.acceleration_level, lambda: {"scene": _scene()}),
        Face("standard_methods", studies.standard_methods, lambda: {"duration": 1.0}),
        Face("stability", studies.stability, lambda: {"scene": _case(), **stability}),
        Face("work_precision", studies.work_precision, _work_arguments),
        Face(
            "right_size",
            studies.right_size,
            lambda: {
                "scene": gallery.pendulum,
                "duration": 1e-3,
                "stepper": lf.MoreauJean(step=1e-4),
                "limit": 1.0,
                "progress": False,
            },
        ),
        Face("StabilityMap.of", studies.StabilityMap.of, lambda: {"method": "a"}, _map),
        Face("StabilityMap.largest_sound", studies.StabilityMap.largest_sound, lambda: {"method": "a"}, _map),
        Face("StabilityMap.csv", studies.StabilityMap.csv, lambda: {"path": "map.csv"}, _map),
        Face("StabilityMap.plot", studies.StabilityMap.plot, dict, _map),
        Face("WorkPrecision.of", studies.WorkPrecision.of, dict, _work),
        Face("WorkPrecision.cheapest", studies.WorkPrecision.cheapest, lambda: {"tolerance": 0.1}, _work),
        Face("WorkPrecision.advice", studies.WorkPrecision.advice, dict, _work),
        Face("WorkPrecision.csv", studies.WorkPrecision.csv, lambda: {"path": "work.csv"}, _work),
        Face("WorkPrecision.plot", studies.WorkPrecision.plot, dict, _work),
    ]


@cache
def faces() -> tuple[Face, ...]:
    """Everything."""
    parts = (
        _bodies_faces,
        _scene_faces,
        _run_faces,
        _solver_faces,
        _law_faces,
        _mesh_faces,
        _advice_faces,
        _gallery_faces,
        _study_faces,
    )
    return tuple(face for part in parts for face in part())


Where = Path
