"""Scenes, what they are compiled to, and results go to other processes; copies are whole and on their own."""

from __future__ import annotations

import multiprocessing
import pickle
import sys
import warnings
from collections.abc import Callable
from copy import deepcopy
from functools import cache, partial
from typing import Any

import numba
import numpy as np
import pytest

import lcpflex as lf
from lcpflex import gallery, meshes
from lcpflex.compile.compiled_scene import CompiledScene
from lcpflex.jit.struct import pack
from lcpflex.model.arrays import Model
from tests.scenes import floor_of

COPIES = {"pickled": lambda thing: pickle.loads(pickle.dumps(thing)), "copied": deepcopy}


def push(t: float) -> float:
    """A force."""
    return 3.0 * t


def pull(t: float, state: Any, scale: float = 2.0) -> tuple[float, float]:
    """Both components of a force."""
    return scale * t, -float(state.u[0])


@numba.njit
def turning(t):
    """A motion, compiled."""
    return 0.1 * (1.0 - np.cos(3.0 * t))


def law(indentation: float, rate: float, impact_speed: float, parameters: Any) -> float:
    """A force law."""
    return float(parameters[0]) * indentation * (1.0 + 0.1 * rate)


class Pusher:
    """A function with a state of its own."""

    def __init__(self, size: float) -> None:
        self.size = size

    def __call__(self, t: float) -> float:
        return self.size * t


@pytest.fixture(autouse=True)
def importable(monkeypatch: pytest.MonkeyPatch) -> None:
    """This module, as pickle looks for its functions."""
    monkeypatch.setitem(sys.modules, __name__, sys.modules.get(__name__) or __import__(__name__))


@cache
def full_scene() -> lf.Scene:
    """One of everything that a scene can hold; nobody changes it."""
    scene = lf.Scene()
    beam = scene.add(lf.Beam(1.0, 0.02, 0.005, density=2700, youngs_modulus=7e10), "beam", (0.0, 2.0), modes=3)
    bar = lf.Bar(1.0, 1e-4, density=2700, youngs_modulus=7e10, elements=10).reduce(3)
    rod = scene.add(bar, "rod", (3.0, 2.0))
    plate = lf.Continuum(meshes.rectangle(0.2, 0.1, 4, 2), density=2700, youngs_modulus=7e10, poissons_ratio=0.3)
    block = scene.add(plate.reduce(2), "block", (5.0, 2.0))
    late = scene.add(plate, "late", (7.0, 2.0), modes=2)
    wheel = scene.add(lf.Disc(0.1, mass=1.0), "wheel", (9.0, 2.0))
    scene.join(lf.Revolute(beam.point("left"), scene.ground.at(0.0, 2.0), name="pin"))
    scene.join(lf.Revolute(wheel.point("center"), scene.ground.at(9.0, 2.0)))
    scene.join(lf.DrivenAngle(wheel.point("center"), scene.ground.at(9.0, 2.0), turning, name="drive"))
    scene.load(lf.Force(rod.point("right"), (push, lf.Table([0.0, 1.0], [0.0, 1.0]))))
    scene.load(lf.Force(block.at(0.0, 0.0), partial(pull, scale=3.0)))
    scene.load(lf.Torque(beam.point("right"), lf.Function(push, breaks=[0.5])))
    scene.load(lf.Torque(late.at(0.05, 0.02), Pusher(2.0)))
    scene.load(lf.Spring(late.at(0.1, 0.05), rod.point("left"), 100.0))
    ground = scene.ground
    floor = ground.half_plane((0.0, 0.0), (0.0, 1.0))
    slot = ground.curved_slot((9.0, 6.0), 1.0, 0.3, 0.0, 1.0)
    straight = ground.straight_slot((12.0, 6.0), (13.0, 6.0), 0.3)
    pins = [scene.add(lf.Disc(0.1, mass=1.0), position=at) for at in ((10.0, 6.0), (12.5, 6.0))]
    scene.contact_slot(pins[0].surface(), slot, friction=0.1)
    scene.contact_slot(pins[1].surface(), straight)
    scene.contact(late.surface(), floor, law=lf.ContactLaw(lf.laws.UserLaw(law, [1e5])))
    scene.contact(beam.circle("right", 0.01), ground.chain([(2.0, 0.0), (0.5, 0.0)]), name="tip")
    scene.contact(beam.node(0.5, 0.0, 0.01), ground.arc((0.5, -1.0), 0.5, 0.0, 3.0))
    scene.contact(rod.circle(rod.point("right"), 0.01), ground.hole((4.0, 2.0), 50.0))
    scene.contact_all(friction=0.2, exclude=[(wheel, scene.ground), (beam, rod)])
    return scene


@cache
def compiled_scene() -> CompiledScene:
    """What it is compiled to."""
    return full_scene().compiled()


def own(scene: lf.Scene | lf.SpatialScene) -> bool:
    """Whether each handle in a scene is of that scene."""
    parts = scene.parts()
    handles: list[Any] = [scene.ground, *parts.placed]
    handles += [point for joint in parts.joints.values() for point in (joint.P, joint.Q)]
    handles += [load.P for load in parts.loads]
    if isinstance(scene, lf.SpatialScene):  # without contacts
        return all(handle.scene is scene for handle in handles)
    handles += parts.surfaces
    handles += [surface for contact in parts.contacts.values() for surface in contact.pair]
    handles += [side for rule in parts.rules for pair in rule.exclude for side in pair]
    return all(handle.scene is scene for handle in handles)


def same(one: Model, other: Model) -> None:
    """The same bits, read-only in both; addresses of functions are those of the process."""
    for part, again in zip(one, other, strict=True):
        for name in part._fields:
            a, b = getattr(part, name), getattr(again, name)
            assert (a.dtype, a.flags.writeable, b.flags.writeable) == (b.dtype, False, False)
            if name != "address":
                np.testing.assert_array_equal(a, b)


def test_the_package_pickles() -> None:
    """By its name."""
    assert pickle.loads(pickle.dumps(lf)) is lf
    assert deepcopy(lf) is lf


@pytest.mark.parametrize("how", COPIES)
def test_scene_with_one_of_everything(how: str) -> None:
    """Handles are of the copy, it compiles to the same bits, and can be built on without touching the first one."""
    scene = full_scene()
    again = COPIES[how](scene)
    assert own(again)
    same(compiled_scene().model, again.compiled().model)
    counts = [len(part) for part in scene.parts()]
    again.load(lf.Torque(again.body("rod").point("left"), 1.0))
    again.contact(again.body("wheel").circle((0.0, 0.0), 0.05), again.ground.half_plane((0.0, -1.0), (0.0, 1.0)))
    assert [len(part) for part in scene.parts()] == counts
    with pytest.raises(lf.ModelError, match="not of another one"):
        again.load(lf.Torque(scene.body("rod").point("left"), 1.0))


@pytest.mark.parametrize("how", COPIES)
def test_a_handle_brings_its_scene(how: str) -> None:
    """A copy of a handle, or of several, is of one copy of the scene."""
    scene = full_scene()
    beam, tip, surface = COPIES[how]((scene.body("beam"), scene.body("beam").point("right"), scene.parts().surfaces[0]))
    assert tip.scene is beam.scene is surface.scene is not scene
    assert own(beam.scene)
    assert beam.scene.body("beam") is beam
    beam.scene.load(lf.Force(tip, (1.0, 0.0)))


@pytest.mark.parametrize("how", COPIES)
def test_bodies_of_copies(how: str) -> None:
    """They answer for places, their levels and displacement fields as before, and are read-only."""
    for name in ("rod", "block", "late", "wheel"):
        body = full_scene().body(name).source
        assert body is not None
        again = COPIES[how](body)
        assert not again.stiffness.flags.writeable
        np.testing.assert_array_equal(again.locate(0.05, 0.0).phi, body.locate(0.05, 0.0).phi)
        if body.fidelity_levels is not None:
            levels = again.fidelity_levels()
            assert [level.name for level in levels] == [level.name for level in body.fidelity_levels()]
            smaller = levels[1].make()
            assert [level.name for level in COPIES[how](smaller).fidelity_levels()] == [level.name for level in levels]
        if body.products is not None:
            np.testing.assert_array_equal(again.products(field), body.products(field))
        if body.statics is not None:
            np.testing.assert_array_equal(again.statics.compliance(0.1, 0.0), body.statics.compliance(0.1, 0.0))
            COPIES[how](again)  # with the factor that it has made


def field(x: float, y: float) -> tuple[float, float]:
    """A displacement."""
    return 1e-3 * x, -1e-3 * y


@pytest.mark.parametrize("how", COPIES)
def test_compiled_scenes(how: str) -> None:
    """The same bits, read-only again, and functions where they are in the copy."""
    compiled = compiled_scene()
    again = COPIES[how](compiled)
    same(compiled.model, again.model)
    assert not any(state.flags.writeable for state in (again.q, again.u))
    assert again.model.signals.address.tolist() == [function.address for function in again.functions]
    assert not set(again.model.signals.address) & set(compiled.model.signals.address)
    assert COPIES[how](again).layout.contacts == compiled.layout.contacts


@pytest.mark.parametrize("how", COPIES)
def test_packed_tuples_are_packed_anew(how: str) -> None:
    """The addresses in a copy are those of its own arrays, and kernels are not compiled for another type."""
    packed = pack(compiled_scene().model)
    again = COPIES[how](packed)
    assert again._type == packed._type
    assert again._address != packed._address
    assert again.bodies._memory[4] == again.bodies.dof.ctypes.data != packed.bodies.dof.ctypes.data


@pytest.mark.parametrize("name", sorted(gallery.scenes()))
def test_scenes_of_the_gallery(name: str) -> None:
    """All of them but those whose functions are inner ones, which say so."""
    scene = gallery.scenes()[name].build()
    if isinstance(scene, lf.UserSystem):
        with pytest.raises(lf.ModelError, match=r"UserSystem: \w+: .* expected a function at the top of a module"):
            pickle.dumps(scene)
    else:
        assert own(pickle.loads(pickle.dumps(scene)))


def inner() -> Callable[..., Any]:
    """A function that no other process can find."""

    def function(t: float) -> float:
        return t

    return function


def loaded(**parts: Any) -> lf.Scene:
    """A disc with a load, a drive or a law."""
    scene = lf.Scene()
    disc = scene.add(lf.Disc(0.1, mass=1.0), "disc", (0.0, 1.0))
    center, origin = disc.point("center"), scene.ground.at(0.0, 1.0)
    if "force" in parts:
        scene.load(lf.Force(center, parts["force"]))
    if "torque" in parts:
        scene.load(lf.Torque(center, 1.0))
        scene.load(lf.Torque(center, parts["torque"]))
    if "motion" in parts:
        scene.join(lf.Revolute(center, origin))
        scene.join(lf.DrivenAngle(center, origin, parts["motion"], name="drive"))
    if "length" in parts:
        scene.join(lf.Distance(center, scene.ground.at(0.0, 3.0), parts["length"], name="rope"))
    if "law" in parts:
        floor = floor_of(scene)
        scene.contact(disc.surface(), floor, law=lf.ContactLaw(lf.laws.UserLaw(parts["law"])), name="floor")
    if "rule" in parts:
        scene.contact_all(law=lf.ContactLaw(lf.laws.UserLaw(parts["rule"])))
    return scene


@pytest.mark.parametrize(
    ("parts", "holder"),
    [
        ({"force": (0.0, lambda t: t)}, r"load 1 \(Force on disc\.center\): value\[1\]: "),
        ({"force": lambda t: (t, t)}, r"load 1 \(Force on disc\.center\): value: "),
        ({"torque": inner()}, r"load 2 \(Torque on disc\.center\): value: inner\.<locals>\.function "),
        ({"torque": lf.Function(lambda t: t)}, r"load 2 \(Torque on disc\.center\): value: "),
        ({"torque": partial(lambda a, t: a * t, 2.0)}, r"load 2 \(Torque on disc\.center\): value: "),
        ({"motion": lambda t: t * t}, r"joint 'drive' \(DrivenAngle\): motion: "),
        ({"length": lambda t: 2.0 + t * t}, r"joint 'rope' \(Distance\): length: "),
        ({"law": lambda d, v, s, p: 1e5 * d}, "contact 'floor': law: "),
        ({"rule": lambda d, v, s, p: 1e5 * d}, "contact_all: law: "),
    ],
)
def test_what_cannot_be_found_by_its_name_is_named(parts: dict[str, Any], holder: str) -> None:
    """Pickling says which load, joint or law holds the function; a copy in the same process needs no name."""
    scene = loaded(**parts)
    with pytest.raises(
        lf.ModelError, match=f"^{holder}.* was given, expected a function at the top of a module"
    ) as told:
        pickle.dumps(scene)
    assert len(str(told.value)) <= 500
    again = deepcopy(scene)
    assert own(again)
    same(scene.compiled().model, again.compiled().model)


def test_user_systems() -> None:
    """By their functions, and again what they were."""
    system = lf.UserSystem([0.0], [1.0], [[2.0]], no_force, gaps=gap, normals=[[1.0]], restitution=0.5)
    again = pickle.loads(pickle.dumps(system))
    assert again.force is no_force
    assert again.restitution.tolist() == [0.5]
    assert deepcopy(system).names == ("contact1",)


def no_force(t: float, q: Any, u: Any) -> Any:
    """Of a system of one coordinate."""
    return np.zeros(1)


def gap(q: Any) -> Any:
    """Of a system of one coordinate."""
    return 1.0 - q


def small_scene() -> lf.Scene:
    """A beam and a ball on the ground, without functions."""
    scene = lf.Scene()
    beam = scene.add(lf.Beam(1.0, 0.02, 0.005, density=2700, youngs_modulus=7e10), "beam", (0.0, 2.0), modes=3)
    ball = scene.add(lf.Disc(0.1, mass=1.0), "ball", (3.0, 0.1), velocity=(1.0, 0.0))
    scene.join(lf.Revolute(beam.point("left"), scene.ground.at(0.0, 2.0), name="pin"))
    scene.load(lf.Torque(beam.point("right"), lf.Harmonic(0.1, 30.0)))
    scene.contact(ball.surface(), floor_of(scene), friction=0.3)
    return scene


def test_another_process_computes_the_same_bits() -> None:
    """A scene and a stepper go there, a result comes back."""
    scene, stepper = small_scene(), lf.MoreauJean(1e-4)
    here = lf.simulate(scene, 0.01, stepper, progress=False)
    with multiprocessing.get_context("spawn").Pool(1) as pool:
        there = pool.apply(lf.simulate, (scene, 0.01, stepper))
    for name in ("q", "u", "force", "impulse", "gap"):
        np.testing.assert_array_equal(getattr(here, name), getattr(there, name))
    assert there.summary().splitlines()[0] == here.summary().splitlines()[0]
    assert there.complete


STEPPERS = {
    "MoreauJean": lf.MoreauJean(1e-4),
    "adaptive": lf.MoreauJean(1e-4, adaptive=lf.AdaptiveStep()),
    "GeneralizedAlpha": lf.GeneralizedAlpha(1e-4),
    "EventDriven": lf.EventDriven(impact=lf.Poisson()),
    "MasslessBoundary": lf.MasslessBoundary(compliance={"contact1": lf.laws.PowerLaw(1e6)}),
    "Smooth": lf.Smooth(lf.Penalty(1e6)),
    "Stiff": lf.Smooth(lf.Penalty(1e6), integrator=lf.Stiff()),
}


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=[] if name == "MoreauJean" else pytest.mark.slow) for name in STEPPERS]
)
def test_results(name: str) -> None:
    """Of each stepper, with what they answer."""
    scene = small_scene() if name != "MasslessBoundary" else loaded()
    if name == "MasslessBoundary":
        scene.contact(scene.body("disc").surface(), floor_of(scene))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        result = lf.simulate(scene, 0.005, STEPPERS[name], progress=False)
    for how in COPIES.values():
        again = how(result)
        np.testing.assert_array_equal(again.q, result.q)
        assert again.summary() == result.summary()
        assert repr(again.contact("contact1").peak_force) == repr(result.contact("contact1").peak_force)


def test_a_step_error_brings_its_result() -> None:
    """To the process that asked for the run."""
    scene = loaded(force=(push, 0.0))
    scene.load(lf.Torque(scene.body("disc").point("center"), fails))
    with pytest.raises(lf.StepError) as told:
        lf.simulate(scene, 0.01, lf.MoreauJean(1e-3), progress=False)
    again = pickle.loads(pickle.dumps(told.value))
    assert str(again) == str(told.value)
    assert again.time == told.value.time
    np.testing.assert_array_equal(again.result.q, told.value.result.q)


def fails(t: float) -> float:
    """A load that ends a run, after the trials of the start."""
    if 0.004 < t < 0.006:
        raise ValueError("no more")
    return 0.0
