"""A callable with arguments that it takes, and small objects of lcpflex that these are made of."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from functools import cache
from typing import Any, NamedTuple

import numpy as np

import lcpflex as lf
from lcpflex import gallery, laws, meshes, solvers
from tests.scenes import floor_of

__all__ = [
    "Face",
    "bar",
    "beam",
    "body",
    "boxed",
    "case",
    "contact",
    "continuum",
    "driven_scene",
    "flexible_rest",
    "followed",
    "lcp",
    "matrices",
    "mesh",
    "mixed",
    "pair",
    "points",
    "rest",
    "resting_scene",
    "result",
    "small_scene",
    "solid",
    "steel",
]


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


def small_scene() -> lf.Scene:
    scene = lf.Scene()
    disc = scene.add(lf.Disc(0.1, mass=1.0), name="disc", position=(0.0, 0.5))
    scene.add(lf.Box(0.2, 0.1, mass=1.0), name="box", position=(1.0, 0.5))
    scene.contact(disc.surface(), floor_of(scene), name="floor", friction=0.3)
    return scene


def body(name: str = "disc") -> Any:
    return small_scene().body(name)


@cache
def result() -> lf.Result:
    """A short run."""
    return lf.simulate(small_scene(), 0.01, lf.MoreauJean(step=1e-3), progress=False)


@cache
def jointed_result() -> lf.Result:
    """A short run with a joint."""
    return lf.simulate(resting_scene(), 0.01, lf.MoreauJean(step=1e-3), progress=False)


def resting_scene() -> lf.Scene:
    """A scene that comes to rest."""
    scene = small_scene()
    scene.join(lf.Revolute(scene.body("box").at(0.0, 0.0), scene.ground.at(1.0, 0.5), name="hinge"))
    return scene


@cache
def rest() -> lf.Rest:
    """Where it does."""
    return lf.equilibrium(resting_scene())


def driven_scene() -> lf.Scene:
    """A scene with a drive that stands."""
    scene = small_scene()
    disc = scene.body("disc").point("center")
    scene.join(lf.DrivenDisplacement(disc, scene.ground.at(0.0, 0.0), 0.5, (0.0, 1.0), name="lift"))
    scene.join(lf.Weld(scene.body("box").at(0.0, 0.0), scene.ground.at(1.0, 0.5), name="hinge"))
    return scene


@cache
def followed() -> lf.EquilibriumPath:
    """A path of two rests."""
    return lf.path(driven_scene(), "lift", (0.5, 0.51), progress=False)


@cache
def flexible_rest() -> lf.Rest:
    """A plate without a load."""
    scene = lf.Scene(gravity=(0.0, 0.0))
    plate = lf.Continuum(lf.meshes.bar(1.0, 0.1, 3), density=7800.0, youngs_modulus=2e11, poissons_ratio=0.3)
    scene.add(plate.reduce(2), name="plate")
    return lf.equilibrium(scene)


@cache
def flexible_result() -> lf.Result:
    """A short run of a flexible body."""
    scene = lf.Scene(gravity=(0.0, -9.81))
    bar = lf.Beam(length=1.0, width=0.02, thickness=0.02, density=7800.0, youngs_modulus=2e11, elements=4)
    scene.add(bar, name="beam", modes=2)
    plate = lf.Continuum(lf.meshes.bar(1.0, 0.1, 3), density=7800.0, youngs_modulus=2e11, poissons_ratio=0.3)
    scene.add(plate.reduce(2), name="plate", position=(0.0, 1.0))
    return lf.simulate(scene, 0.003, lf.MoreauJean(step=1e-3), progress=False)


def points() -> dict[str, Any]:
    scene = small_scene()
    return {"P": scene.body("disc").point("center"), "Q": scene.ground.at(0.0, 0.0)}


def contact() -> solvers.ContactProblem:
    return solvers.ContactProblem(np.eye(3) * 2.0, [-1.0, -1.0, 0.1], [0.0, 0.3])


def lcp() -> solvers.Lcp:
    return solvers.Lcp([[2.0, 1.0], [1.0, 2.0]], [-1.0, -1.0])


def boxed() -> solvers.BoxedLcp:
    return solvers.BoxedLcp(np.eye(2), [-1.0, 1.0], [0.0, -1.0], [1.0, 1.0])


def mixed() -> solvers.MixedLcp:
    return solvers.MixedLcp(np.eye(2), [-1.0, 1.0], [0])


def steel() -> laws.Material:
    return laws.Material(2e11, 0.3)


def pair() -> laws.CylinderPair:
    return laws.CylinderPair.internal(0.0105, 0.01, 0.02, steel())


def beam() -> lf.Beam:
    return lf.Beam(0.7, 0.028, 0.005, 2700.0, 6.9e10, elements=6)


def bar() -> lf.Bar:
    return lf.Bar(1.0, 1e-4, 7800.0, 2e11, elements=6)


@cache
def mesh() -> Any:
    return meshes.rectangle(0.4, 0.1, 4, 2)


def continuum() -> lf.Continuum:
    return lf.Continuum(mesh(), 7800.0, 2e11, 0.3)


def solid() -> lf.SolidOfRevolution:
    return lf.SolidOfRevolution(mesh(), 7800.0, 2e11, 0.3)


def matrices() -> dict[str, Any]:
    elements = continuum().finite_elements()
    return {"mass": elements.mass, "stiffness": elements.stiffness, "coordinates": elements.places}


def case() -> Any:
    return gallery.scenes()["bouncing_ball"]
