"""The stepper that a run is made with where none is given, or only its name."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import lcpflex as lf
from lcpflex.runs import default_stepper
from tests.flat_scenes import STEEL, bar_at_wall, bar_on_roller

PLANE, SPACE = 2, 3


def balls(count: int, dim: int = PLANE, listed: bool = False, height: float = 0.101) -> Any:
    """Balls above each other on the ground, under a rule, or each pair of neighbours with a contact of its own."""
    scene: Any = lf.Scene(gravity=(0.0, -9.81)) if dim == PLANE else lf.SpatialScene(gravity=(0.0, 0.0, -9.81))
    up = np.eye(dim)[-1]
    model: Any = lf.Disc(radius=0.1, mass=1.0) if dim == PLANE else lf.Sphere(radius=0.1, mass=1.0)
    bodies = [scene.add(model, f"ball {k}", (height + 0.21 * k) * up) for k in range(count)]
    wall = scene.ground.half_plane if dim == PLANE else scene.ground.plane
    floor = wall(0.0 * up, up)
    if not listed:
        scene.contact_all(friction=0.3)
        return scene
    for below, above in zip([None, *bodies], bodies, strict=False):
        scene.contact(above.surface(), floor if below is None else below.surface(), friction=0.3)
    return scene


def beams(joined: bool) -> lf.Scene:
    """Two beams, one above the other or, where they are joined, one behind the other and no contact."""
    scene = lf.Scene(gravity=(0.0, -9.81))
    model = lf.Beam(1.0, 0.02, 0.01, 7800.0, 2.1e11, elements=4, axial=False)
    first = scene.add(model, "first", position=(0.0, 0.3), modes=2)
    second = scene.add(model, "second", position=(1.0, 0.3) if joined else (0.0, 0.6), modes=2)
    if joined:
        scene.join(lf.Revolute(first.point("right"), second.point("left")))
    scene.ground.half_plane((0.0, 0.0), (0.0, 1.0))
    scene.contact_all()
    return scene


def oscillator(contacts: int = 0) -> lf.UserSystem:
    """A user's own system of as many coordinates as contacts, at least two, with frequencies of 10 and 2000 rad/s."""
    n = max(2, contacts)
    stiffness = np.diag(np.linspace(10.0, 2000.0, n) ** 2)
    some: dict[str, Any] = {"gaps": lambda q: q + 1.0, "normals": np.eye(n)} if contacts else {}
    return lf.UserSystem(np.full(n, 1e-3), np.zeros(n), np.eye(n), lambda t, q, u: 0.0 * q, stiffness=stiffness, **some)


def chosen(scene: Any, duration: float = 0.1) -> default_stepper.Choice:
    source = scene if isinstance(scene, lf.UserSystem) else scene.compile()
    return default_stepper.Wish(None, duration).choice(source)


@pytest.mark.parametrize("dim", [PLANE, SPACE])
@pytest.mark.parametrize("listed", [False, True])
def test_piles_are_counted(dim: int, listed: bool) -> None:
    few, many = chosen(balls(12, dim, listed)), chosen(balls(13, dim, listed))
    assert few.stepper == lf.EventDriven(rtol=1e-6)
    assert "only 12 bodies" in few.note
    assert few.other == lf.MoreauJean(step=2e-4)
    assert many.stepper == lf.MoreauJean(step=2e-4)
    assert "13 bodies" in many.note
    assert many.other is None
    assert chosen(balls(6, dim, listed)).other == lf.GeneralizedAlpha(step=2e-4)


@pytest.mark.parametrize("model", [lf.Cuboid(0.2, 0.2, 0.2, mass=1.0), lf.Cylinder(0.1, 0.2, mass=1.0)])
def test_faces_count_by_the_points_they_rest_on(model: Any) -> None:
    def stack(count: int) -> lf.SpatialScene:
        scene = lf.SpatialScene(gravity=(0.0, 0.0, -9.81))
        for k in range(count):
            scene.add(model, f"body {k}", (0.0, 0.0, 0.25 * (k + 1)))
        scene.ground.plane((0.0, 0.0, 0.0), (0.0, 0.0, 1.0))
        scene.contact_all()
        return scene

    assert isinstance(chosen(stack(4)).stepper, lf.EventDriven)
    assert chosen(stack(5)).stepper == lf.MoreauJean(step=2e-4)


def scattered(count: int) -> lf.Scene:
    """Discs beside each other, each with a contact with the ground alone."""
    scene = lf.Scene(gravity=(0.0, -9.81))
    floor = scene.ground.half_plane((0.0, 0.0), (0.0, 1.0))
    for k in range(count):
        disc = scene.add(lf.Disc(radius=0.1, mass=1.0), position=(0.3 * k, 0.2))
        scene.contact(disc.surface(), floor)
    return scene


def test_bodies_that_meet_the_ground_alone_are_no_pile() -> None:
    choice = chosen(scattered(20))
    assert isinstance(choice.stepper, lf.EventDriven)
    assert "no two bodies touch each other" in choice.note


def test_flexible_bodies() -> None:
    lying = chosen(beams(joined=False))
    assert isinstance(lying.stepper, lf.GeneralizedAlpha)
    assert "'first' and 'second'" in lying.note
    assert isinstance(chosen(beams(joined=True)).stepper, lf.EventDriven)
    slow = chosen(beams(joined=True), 1e6)  # many steps of its modes, and as many of the other method
    assert isinstance(slow.stepper, lf.EventDriven)


def test_contacts_that_close_point_by_point_get_a_massless_boundary() -> None:
    choice = chosen(bar_on_roller(), 2.5e-4)
    assert isinstance(choice.stepper, lf.MasslessBoundary)
    assert isinstance(choice.other, lf.GeneralizedAlpha)
    assert "one by one" in choice.note
    assert eval(choice.note.rpartition("stepper=")[2].removesuffix(" pins it"), {"lf": lf}) == choice.stepper
    assert isinstance(chosen(bar_on_roller(friction=0.3), 2.5e-4).stepper, lf.MasslessBoundary)
    # nothing bounces by a coefficient there, a second takes too many steps, and what begins with a corner may end flat
    for scene, duration in ((bar_on_roller(restitution=0.5), 2.5e-4), (bar_on_roller(), 1.0), (bar_at_wall(0.1), 1e-4)):
        assert not isinstance(chosen(scene, duration).stepper, lf.MasslessBoundary)


def test_a_solid_on_a_sphere_gets_a_massless_boundary() -> None:
    def under(x: Any, y: Any, z: Any) -> Any:
        return (z < -0.00249) & (np.abs(x) < 2.6e-3) & (np.abs(y) < 2.6e-3)

    solid = lf.Solid.box((0.1, 0.02, 0.005), elements=(40, 8, 2), **STEEL, sets={"under": under})
    for contact, kind in (({"contact": "under"}, lf.MasslessBoundary), ({"boundary": "under"}, lf.EventDriven)):
        scene = lf.SpatialScene(gravity=(0.0, 0.0, 0.0))
        plate = scene.add(solid.reduce(12, rows="normal", **contact), "plate", velocity=(0.0, 0.0, -0.4))
        sphere = scene.ground.sphere((0.0, 0.0, -0.2025001), 0.2)
        scene.contact(plate.face("under"), sphere, points="nodes")
        assert isinstance(chosen(scene, 2e-4).stepper, kind)


@pytest.mark.parametrize("friction", [0.0, 0.3])
def test_the_massless_boundary_is_chosen_for_what_impacts_make_explode(friction: float) -> None:
    scene = bar_on_roller(20, friction)
    result = lf.simulate(scene, 2.5e-4)
    assert result.stepper.startswith("MasslessBoundary")
    assert result.complete
    gained = result.energies.stored + result.energies.friction - result.energies.stored[0]
    assert np.abs(gained).max() < 1e-3 * result.energies.stored[0]
    assert explodes(scene)


def explodes(scene: lf.Scene) -> bool:
    """Whether impacts step by step gain energy without end; the last digit decides if beyond all numbers."""
    try:
        before = lf.simulate(scene, 2.5e-4, lf.GeneralizedAlpha(step=5e-7))
    except lf.StepError as error:
        return "no longer finite" in str(error)
    return bool(before.energies.stored[-1] > 10.0 * before.energies.stored[0])


@pytest.mark.parametrize("basis", ["free", "held"])
def test_flat_contacts_get_more_damping(basis: str) -> None:
    """Where generalised-alpha takes over: with .8 it gives a bar 8 % of energy in steps of 5 us, with .5 none."""
    choice = chosen(bar_at_wall(basis=basis), 1.2e-4)
    assert isinstance(choice.stepper, lf.EventDriven)
    assert choice.other == lf.GeneralizedAlpha(step=2.4e-7, rho_inf=0.5)
    assert chosen(bar_at_wall(0.1, basis=basis), 1.2e-4).other == lf.GeneralizedAlpha(step=2.4e-7)
    left = [
        float(result.energies.stored[-1] / result.energies.stored[0])
        for rho in (0.5, 0.8)
        for result in [lf.simulate(bar_at_wall(basis=basis), 1.2e-4, lf.GeneralizedAlpha(step=5e-6, rho_inf=rho))]
    ]
    assert left[0] < 1.0
    assert left[1] > 1.05


def test_fast_modes_take_too_many_steps() -> None:
    stiff = lf.UserSystem([0.0, 0.0], [1.0, 0.0], np.eye(2), lambda t, q, u: 0.0 * q, stiffness=np.diag([1e2, 1e12]))
    choice = chosen(stiff, 1.0)
    assert choice.stepper == lf.GeneralizedAlpha(step=2e-3)
    assert "modes up to 1e+06 rad/s would take 3e+05 steps" in choice.note


@pytest.mark.parametrize(("count", "work"), [(10, 50.0), (20, 50.0 * 50.0 / 60.0), (200, 10.0)])
def test_many_coordinates_get_less_work(count: int, work: float) -> None:
    assert chosen(scattered(count)).most == pytest.approx(work * 0.1 / 2e-4, abs=1.0)


def test_laws_are_never_left_to_steps_of_one_length() -> None:
    scene = lf.Scene(gravity=(0.0, -9.81))
    disc = scene.add(lf.Disc(radius=0.1, mass=1.0), position=(0.0, 0.11))
    scene.contact(disc.surface(), scene.ground.half_plane((0.0, 0.0), (0.0, 1.0)), law=lf.Penalty(1e6))
    choice = chosen(scene)
    assert (choice.stepper, choice.other) == (lf.EventDriven(rtol=1e-6), None)


@pytest.mark.parametrize(("contacts", "kind"), [(0, lf.EventDriven), (3, lf.EventDriven), (40, lf.MoreauJean)])
def test_systems_of_a_users_own(contacts: int, kind: type) -> None:
    assert isinstance(chosen(oscillator(contacts)).stepper, kind)


@pytest.mark.parametrize(
    ("turn", "fall", "expected"),
    [
        ((0.0, 0.0, 0.0), 0.0, 2e-3),  # 1/500 of a second
        ((0.0, 0.0, 0.0), 9.81e6, 0.01 * np.sqrt(2.0 / 9.81e6)),
        ((0.0, 4e3, 0.0), 0.0, 5e-6),
    ],
)
def test_the_step_of_a_scene_in_space(turn: tuple[float, float, float], fall: float, expected: float) -> None:
    scene = lf.SpatialScene(gravity=(0.0, 0.0, -fall))
    radius = np.sqrt(5.0 / 3.0)  # of a ball with a polar radius of gyration of 1 m
    scene.add(lf.Sphere(radius=radius, mass=2.0), angular_velocity=turn)
    assert default_stepper.step_of(scene.compile(), 1.0) == pytest.approx(expected, rel=5e-3)


def test_the_step_of_a_scene_in_the_plane() -> None:
    scene = lf.Scene(gravity=(0.0, 0.0))
    body = scene.add(lf.Disc(radius=np.sqrt(2.0), mass=2.0), velocity=(3e3, 4e3))  # polar radius of gyration 1 m
    assert default_stepper.step_of(scene.compile(), 1.0) == pytest.approx(4e-6)
    scene.load(lf.Force(body.point("center"), (lf.Harmonic(1.0, 2.0 * np.pi * 1e6), 0.0)))
    assert default_stepper.step_of(scene.compile(), 1.0) == pytest.approx(1e-6 / 40.0)


def test_the_step_of_modes() -> None:
    slow = lf.UserSystem([0.0], [1.0], [[4.0]], lambda t, q, u: 0.0 * q, stiffness=[[4.0 * 100.0**2]])
    assert default_stepper.step_of(slow, 1.0) == pytest.approx(2.0 * np.pi / 100.0 / 40.0, rel=5e-3)


def test_a_run_tells_what_was_chosen_and_how_to_pin_it() -> None:
    result = lf.simulate(balls(2), 0.05)
    told = next(note for note in result.notes if note.startswith("stepper chosen"))
    words = told.rpartition("stepper=")[2].removesuffix(" pins it")
    pinned = eval(words, {"lf": lf})
    assert result.stepper == repr(pinned)
    again = lf.simulate(balls(2), 0.05, pinned)
    assert np.array_equal(again.q, result.q)
    assert not [note for note in again.notes if "stepper chosen" in note]


@pytest.mark.parametrize(
    ("name", "kind"),
    [("moreau-jean", "MoreauJean(step=0.0001"), ("generalized-alpha", "GeneralizedAlpha("), ("event-driven", "Event")],
)
def test_a_stepper_by_name(name: str, kind: str) -> None:
    result = lf.simulate(balls(1), 0.05, name)
    assert result.stepper.startswith(kind)
    assert not [note for note in result.notes if "stepper chosen" in note]


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ("smooth", r"stepper: 'smooth' .* stiffness: expected lf.Smooth\(lf.Penalty\(stiffness\)\)"),
        (
            "event-drivn",
            r"stepper: 'event-drivn' was given \(did you mean 'event-driven'\?\), expected a stepper .* None",
        ),
        (3, "stepper: 3 was given, expected a stepper such as"),
        (lf.EventDriven, "stepper: .*EventDriven.* was given, expected a stepper such as"),
    ],
)
def test_what_names_no_stepper_is_refused(given: Any, words: str) -> None:
    with pytest.raises(lf.ModelError, match=words):
        lf.simulate(balls(1), 0.05, given)


def test_a_wrong_duration_is_refused_by_its_name() -> None:
    with pytest.raises(lf.ModelError, match="duration: -1"):
        lf.simulate(balls(1), -1.0)


@pytest.fixture
def overworked(monkeypatch: pytest.MonkeyPatch) -> None:
    """A step for each hundred of the other method."""
    monkeypatch.setattr(default_stepper, "WORK", 1e-2)
    monkeypatch.setattr(default_stepper, "LEAST_WORK", 1e-2)


@pytest.mark.parametrize("dim", [PLANE, SPACE])
@pytest.mark.usefixtures("overworked")
def test_too_much_work_begins_the_run_anew(dim: int) -> None:
    result = lf.simulate(balls(2, dim), 0.5)
    told = next(note for note in result.notes if note.startswith("stepper chosen"))
    assert told.startswith("stepper chosen: GeneralizedAlpha(step=0.001), as EventDriven(rtol=1e-06) took more than 5 ")
    other = lf.simulate(balls(2, dim), 0.5, lf.GeneralizedAlpha(step=1e-3))
    assert result.stepper == other.stepper
    assert result.complete
    assert np.array_equal(result.times, other.times)
    assert np.array_equal(result.q, other.q)


@pytest.mark.usefixtures("overworked")
def test_a_run_begun_anew_goes_on_from_its_checkpoint(tmp_path: Path) -> None:
    path = tmp_path / "run.npz"
    whole = lf.simulate(balls(2), 0.5)
    part = lf.simulate(balls(2), 0.5, checkpoint=path, budget=1e-6)
    assert not part.complete
    result = lf.resume(path)
    assert result.complete
    assert result.stepper == whole.stepper
    assert np.array_equal(result.q, whole.q)
    assert result.notes == whole.notes


def bouncing() -> lf.Scene:
    """A disc that takes more than a hundred steps and impacts in 50 s."""
    scene = lf.Scene(gravity=(0.0, -9.81))
    disc = scene.add(lf.Disc(radius=0.1, mass=1.0), "disc", position=(0.0, 0.1), velocity=(0.0, 1.0))
    scene.contact(disc.surface(), scene.ground.half_plane((0.0, 0.0), (0.0, 1.0)), restitution=0.999)
    return scene


def test_too_much_work_after_a_break_begins_the_run_anew(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(default_stepper, "LEAST_WORK", 0)
    monkeypatch.setattr(default_stepper, "WORK", 2.4e-3)  # a hundred of its steps and impacts
    path = tmp_path / "run.npz"
    whole = lf.simulate(bouncing(), 50.0)
    part = lf.simulate(bouncing(), 50.0, checkpoint=path, budget=1e-6)
    assert part.stepper.startswith("EventDriven")
    result = lf.resume(path, bouncing())
    assert result.stepper == whole.stepper
    assert result.stepper.startswith("GeneralizedAlpha")
    assert result.notes == whole.notes
    assert np.array_equal(result.q, whole.q)


def test_a_stepper_that_stops_is_followed_by_the_other(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(default_stepper, "_event_driven", lambda: lf.EventDriven(rtol=1e-6, most_events=1e-6))
    scene = bouncing()
    with pytest.raises(lf.StepError, match="followed each other"):
        lf.simulate(scene, 400.0, lf.EventDriven(rtol=1e-6, most_events=1e-6))
    result = lf.simulate(scene, 400.0)
    assert "the last 1000 events" in "".join(result.notes)
    assert result.stepper.startswith("GeneralizedAlpha")
    assert result.complete


def pushed(load: Callable[[float], tuple[float, float]]) -> lf.Scene:
    """A ball with a load of a user's that is not probed before the run."""
    scene = lf.Scene(gravity=(0.0, -9.81))
    ball = scene.add(lf.Disc(radius=0.1, mass=1.0))
    scene.load(lf.Force(ball.point("center"), lf.Function(load, shortest=1.0)))
    return scene


def test_what_a_function_of_the_user_raises_ends_the_run() -> None:
    def load(t: float) -> tuple[float, float]:
        if t > 0.02:
            calls.append(t)
            raise ZeroDivisionError("on purpose")
        return 0.0, 0.0

    calls: list[float] = []
    with pytest.raises(lf.StepError, match="on purpose"):
        lf.simulate(pushed(load), 0.05)
    assert len(calls) == 1


@pytest.mark.parametrize("second", [False, True])
def test_an_interrupted_run_is_given_as_far_as_it_came(second: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    def instead(self: default_stepper.Choice, run: Any, message: str) -> default_stepper.Choice:
        begun.append(1)
        return replaced(self, run, message)

    def load(t: float) -> tuple[float, float]:
        if t > 0.01 and len(begun) == second:
            raise KeyboardInterrupt
        return 0.0, 0.0

    begun: list[int] = []
    replaced = default_stepper.Choice.instead
    monkeypatch.setattr(default_stepper.Choice, "instead", instead)
    monkeypatch.setattr(default_stepper, "LEAST_WORK", 1e-9 if second else 10)
    result = lf.simulate(pushed(load), 0.05)
    assert not result.complete
    assert "interrupted" in result.message
    assert result.stepper.startswith("GeneralizedAlpha" if second else "EventDriven")
    assert 0.0 < result.times[-1] < 0.04
