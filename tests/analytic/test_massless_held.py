"""Bodies that joints, springs and forces hold, under the massless boundary: static sag, first frequency, steps."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cache

import numpy as np
import numpy.typing as npt
import pytest

import lcpflex as lf
from lcpflex.scene.handles import Placed

FloatArray = npt.NDArray[np.float64]

LENGTH, WIDTH, HEIGHT, DENSITY, MODULUS = 0.5, 0.02, 0.004, 7850.0, 2.1e11
STRIP = lf.Beam(LENGTH, WIDTH, HEIGHT, DENSITY, MODULUS)
RIGIDITY = MODULUS * WIDTH * HEIGHT**3 / 12.0
WEIGHT = 9.81 * DENSITY * WIDTH * HEIGHT  # [N/m]
NAMED = {
    "foot": lambda x, y: (np.abs(x) < 1e-9) & (np.abs(y) < 1e-9),
    "tip": lambda x, y: (np.abs(x - LENGTH) < 1e-9) & (np.abs(y) < 1e-9),
    "patch": lambda x, y: (np.abs(x - 0.45) < 0.011) & (y > 0.0099),
}
WITHIN = 5e-3


@cache
def solid() -> lf.Continuum:
    """The strip as a mesh, which is made when a test asks for it: skfem is dear."""
    return lf.Continuum(lf.meshes.bar(LENGTH, 0.02, 50), 7850.0, 2.1e11, 0.3, 0.02, sets=NAMED)


def strip(scene: lf.Scene, modes: int, **given: object) -> Placed:
    """The strip along x, above a stop that it never reaches."""
    body = scene.add(STRIP, name="strip", modes=modes, **given)
    scene.contact(body.surface("top"), scene.ground.circle((0.45, 5.0), 0.02), name="stop")
    return body


def weld(scene: lf.Scene, body: Placed, x: float = 0.0) -> None:
    scene.join(lf.Weld(body.at(x, 0.0), scene.ground.at(x, 0.0)))


def guide(scene: lf.Scene, body: Placed, x: float) -> None:
    scene.join(lf.PointOnLine(body.at(x, 0.0), scene.ground.at(x, 0.0), (1.0, 0.0)))


# closed forms


def cantilever(modes: int) -> lf.Scene:
    scene = lf.Scene()
    weld(scene, strip(scene, modes))
    return scene


def simply_supported(modes: int) -> lf.Scene:
    scene = lf.Scene()
    body = strip(scene, modes)
    scene.join(lf.Revolute(body.point("left"), scene.ground.at(0.0, 0.0)))
    guide(scene, body, LENGTH)
    return scene


def built_in(modes: int) -> lf.Scene:
    scene = lf.Scene()
    body = strip(scene, modes)
    for x in (0.0, LENGTH):
        weld(scene, body, x)
    return scene


def free_modes_alone(modes: int) -> lf.Scene:
    """Reduced before anybody knew how it is held: half of its modes have no mass."""
    scene = lf.Scene()
    body = scene.add(STRIP.reduce(2 * modes + 6), name="strip")
    scene.contact(body.surface("top"), scene.ground.circle((0.45, 5.0), 0.02), name="stop")
    weld(scene, body)
    return scene


@pytest.mark.parametrize("modes", [3, 8, pytest.param(24, marks=pytest.mark.slow)])
@pytest.mark.parametrize(
    ("build", "place", "share", "root", "duration"),
    [
        (cantilever, "right", 1.0 / 8.0, 1.87510407, 0.15),
        (simply_supported, "center", 5.0 / 384.0, math.pi, 0.06),
        (built_in, "center", 1.0 / 384.0, 4.73004074, 0.03),
    ],
)
def test_sag_and_first_frequency_are_those_of_the_beam(
    build: Callable[[int], lf.Scene], place: str, share: float, root: float, duration: float, modes: int
) -> None:
    """Let go level, it swings about the sag w L^4 ``share`` / (E I), by (root/L)^2 sqrt(E I / (rho A)) at first."""
    result = lf.simulate(build(modes), duration, lf.MasslessBoundary(), record=duration / 300.0)
    sag = WEIGHT * LENGTH**4 * share / RIGIDITY
    omega = (root / LENGTH) ** 2 * math.sqrt(RIGIDITY * 9.81 / WEIGHT)
    y = result.point("strip", place)[:, 1]

    def fitted(part: float) -> tuple[float, float]:
        phase = part * omega * result.times
        basis = np.column_stack([np.ones_like(phase), np.cos(phase), np.sin(phase)])
        found, left, *_ = np.linalg.lstsq(basis, y, rcond=None)
        return float(left[0]), -float(found[0])

    parts = np.linspace(0.97, 1.03, 121)
    best = parts[int(np.argmin([fitted(part)[0] for part in parts]))]
    assert best == pytest.approx(1.0, abs=WITHIN)
    assert fitted(best)[1] == pytest.approx(sag, rel=WITHIN)
    assert result.energies.relative_remainder < 1e-4
    assert result.verdict.word == "Unverified"


def test_a_welded_strip_takes_a_tenth_of_the_steps() -> None:
    """1.9 million they were: a step was as short as a contact beside the weld would need."""
    assert lf.simulate(cantilever(8), 1e-3, lf.MasslessBoundary()).steps < 1.9e5 * 1e-3 / 0.15


# against modes that all have mass


def three_supports(modes: int) -> lf.Scene:
    """Its lowest modes are too high for three free ones, whatever has mass."""
    scene = simply_supported(modes + 5)
    guide(scene, scene.body("strip"), 0.23)
    return scene


def slides(modes: int) -> lf.Scene:
    """By a slider joint at its end, against a spring; tilted."""
    scene = lf.Scene()
    body = strip(scene, modes, angle=0.3)
    axis = (math.cos(0.3), math.sin(0.3))
    scene.join(lf.Prismatic(body.point("left"), scene.ground.at(0.0, 0.0), axis=axis))
    scene.load(lf.Spring(body.point("left"), scene.ground.at(-0.1 * axis[0], -0.1 * axis[1]), stiffness=1e6))
    return scene


def driven_angle(modes: int) -> lf.Scene:
    scene = lf.Scene(gravity=(0.0, 0.0))
    body = strip(scene, modes)
    scene.join(lf.Revolute(body.point("left"), scene.ground.at(0.0, 0.0)))
    swing = lf.Harmonic(0.02, 60.0, phase=-0.5 * math.pi, mean=0.02)
    scene.join(lf.DrivenAngle(body.point("left"), scene.ground.at(0.0, 0.0), swing))
    return scene


def driven_end(modes: int) -> lf.Scene:
    scene = lf.Scene(gravity=(0.0, 0.0))
    body = strip(scene, modes)
    weld(scene, body)
    lift = lf.Harmonic(0.005, 60.0, phase=-0.5 * math.pi, mean=0.005)
    scene.join(lf.DrivenDisplacement(body.point("right"), scene.ground.at(LENGTH, 0.0), lift, (0.0, 1.0)))
    return scene


def on_a_spring(modes: int, stiffness: float = 2e4) -> lf.Scene:
    scene = lf.Scene()
    body = strip(scene, modes)
    scene.join(lf.Revolute(body.point("left"), scene.ground.at(0.0, 0.0)))
    scene.load(lf.Spring(body.at(0.4, 0.0), scene.ground.at(0.4, -0.1), stiffness=stiffness, length=0.1))
    return scene


def pushed_at_its_end(modes: int) -> lf.Scene:
    """Where a residual mode is, for the contact."""
    scene = lf.Scene(gravity=(0.0, 0.0))
    body = strip(scene, modes)
    weld(scene, body)
    scene.load(lf.Force(body.point("right"), (0.0, -2.0)))
    return scene


def twisted(modes: int) -> lf.Scene:
    scene = lf.Scene(gravity=(0.0, 0.0))
    body = strip(scene, modes)
    weld(scene, body)
    scene.load(lf.Torque(body.point("center"), 0.3))
    return scene


def carries_a_box(modes: int) -> lf.Scene:
    scene = cantilever(modes)
    box = scene.add(lf.Box(0.02, 0.02, mass=0.1), "box", position=(LENGTH, 0.0))
    scene.join(lf.Weld(box.at(0.0, 0.0), scene.body("strip").point("right")))
    return scene


def carries_a_strip(modes: int) -> lf.Scene:
    """Which no contact names: all of its modes have mass."""
    scene = cantilever(modes)
    second = scene.add(STRIP, "second", modes=modes, position=(LENGTH, 0.0))
    scene.join(lf.Weld(second.point("left"), scene.body("strip").point("right")))
    return scene


def of_a_mesh(modes: int, reduce: Callable[[int], lf.Body] | None = None) -> lf.Scene:
    scene = lf.Scene()
    body = scene.add(solid(), "strip", modes=modes) if reduce is None else scene.add(reduce(modes), "strip")
    scene.contact(body.surface("outline"), scene.ground.circle((0.45, 5.0), 0.02), name="stop")
    weld(scene, body)
    return scene


def by_craig_bampton(modes: int) -> lf.Scene:
    return of_a_mesh(modes, lambda n: lf.craig_bampton(solid(), ["foot", "patch"], modes=n))


def by_regions(modes: int) -> lf.Scene:
    return of_a_mesh(modes, lambda n: lf.sub_regional(solid(), ["foot", "patch"], modes=n))


def by_residual_compliance(modes: int) -> lf.Scene:
    return of_a_mesh(modes, lambda n: lf.residual_compliance(solid(), ["foot", "patch"], modes=n))


def of_matrices(modes: int) -> lf.Scene:
    """Of which nothing but nodes is known."""
    mesh = solid().finite_elements()
    nodes = {name: int(node) for name, node in mesh.points.items()} | {"patch": int(mesh.sets["patch"][0])}
    matrices = lf.Matrices(mesh.mass, mesh.stiffness, mesh.places, nodes)
    held = [
        *(lf.Interface(name, moment=False, contact=False) for name in ("foot", "tip")),
        lf.Interface("patch", moment=False),
    ]
    scene = lf.Scene()
    body = scene.add(matrices.reduce(modes, interfaces=held), "strip")
    scene.contact(body.node(*mesh.places[nodes["patch"]]), scene.ground.circle((0.45, 5.0), 0.02), name="stop")
    scene.join(lf.Revolute(body.point("foot"), scene.ground.at(0.0, 0.0)))
    scene.join(lf.PointOnLine(body.point("tip"), scene.ground.at(LENGTH, 0.0), (1.0, 0.0)))
    return scene


HELD = {
    free_modes_alone: "right", three_supports: "center", slides: "right", driven_angle: "right", driven_end: "center",
    on_a_spring: "right", pushed_at_its_end: "right", twisted: "right", carries_a_box: "right",
    carries_a_strip: "right", of_a_mesh: "tip", by_craig_bampton: "tip", by_regions: "tip",
    by_residual_compliance: "tip", of_matrices: "patch",
}  # fmt: skip


@pytest.mark.parametrize("modes", [3, *(pytest.param(n, marks=pytest.mark.slow) for n in (8, 24))])
@pytest.mark.parametrize("build", HELD)
def test_what_holds_a_body_finds_all_of_its_compliance(build: Callable[[int], lf.Scene], modes: int) -> None:
    """The motion of a place that nothing holds is that under a scheme for which all modes have mass."""
    duration = 0.02
    motions = []
    for stepper in (lf.MasslessBoundary(), lf.MoreauJean(step=2e-6)):
        result = lf.simulate(build(modes), duration, stepper, record=duration / 100.0)
        assert result.energies.relative_remainder < 1e-3
        moved = result.point("strip", HELD[build]).T
        motions.append(np.array([np.interp(np.linspace(0.0, duration, 99), result.times, part) for part in moved]))
    assert np.abs(motions[0] - motions[1]).max() < WITHIN * np.ptp(motions[1], axis=1).max()
