"""Sensors that cannot be are refused by name; those that fail under way end the run, and lose nothing."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import lcpflex as lf
from tests.scenes import disc_on_floor
from tests.unit.runs.sensor_scenes import struck_beam

STEP = lf.MoreauJean(step=1e-3)
of = lf.sensors


def with_sensor(sensor: Any) -> lf.Scene:
    scene = disc_on_floor(0.5)
    scene.sensor(sensor)
    return scene


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: of.Point("center"), "Point: P: 'center' was given, expected a point"),
        (lambda: of.Point(lf.Scene().ground.at(0, 0)), "on the ground was given, expected a point of a body"),
        (lambda: of.Body(3), "Body: body: 3 was given, expected a body of the scene"),
        (lambda: of.Body("disc", every=-1.0), "Body: every: -1"),
        (lambda: of.Body("disc", every="1"), "Body: every: '1'"),
        (lambda: of.Energy(name=3), "Energy: name: 3 was given, expected a text"),
        (lambda: of.Coordinates("disc.x"), "Coordinates: names: 'disc.x' was given"),
        (lambda: of.Coordinates(("disc.x", "disc.x")), "expected different names"),
        (lambda: of.Contact(""), "Contact: contact: '' was given, expected the name of a contact"),
        (lambda: of.Section("disc", "middle"), "Section: x: 'middle'"),
        (lambda: of.Stress("disc", (0.0,)), "Stress: place"),
        (lambda: of.Function(3), "Function: function: 3 was given"),
        (lambda: of.Function(abs, columns=("a", "a")), "Function: columns"),
        (lambda: of.Function(abs, columns=("a", "b"), units=("m",)), "Function: units"),
    ],
)
def test_wrong_when_made(make: Callable[[], Any], words: str) -> None:
    with pytest.raises(lf.ModelError, match=words.replace("(", r"\(").replace(")", r"\)")):
        make()


@pytest.mark.parametrize(
    ("sensor", "words"),
    [
        (of.Body("disk"), "sensor 'sensor1': body: no body 'disk', expected one of 'disc'"),
        (of.Coordinates(("disc.z",)), "sensor 'sensor1': names: no coordinate 'disc.z'"),
        (of.Reaction("hinge"), "sensor 'sensor1': joint: no joint 'hinge'"),
        (of.Contact("flor"), "sensor 'sensor1': name: no contact 'flor', expected one of 'floor'"),
        (of.Section("disc", 0.1), "sensor 'sensor1': body: 'disc' was given, expected a Beam or Bar"),
        (of.Stress("disc", (0.0, 0.0)), "sensor 'sensor1': body: 'disc' was given"),
        (of.Function(lambda now: now.nothing), "sensor 'sensor1': function: the function raised AttributeError"),
        (of.Function(lambda now: [1.0, 2.0]), "sensor 'sensor1': function: it returned"),
        (of.Energy(every=1e-300), "sensor 'sensor1': every: 1e-300 was given"),
    ],
)
def test_wrong_in_its_scene(sensor: Any, words: str) -> None:
    with pytest.raises(lf.ModelError, match=words):
        lf.simulate(with_sensor(sensor), 0.01, STEP)


def test_what_a_scene_does_not_take() -> None:
    scene = disc_on_floor(0.5)
    for wrong in (3, of.Point, lf.Force(scene.body("disc").point("center"), (0.0, 1.0))):
        with pytest.raises(lf.ModelError, match=r"sensor: .* was given, expected a sensor"):
            scene.sensor(wrong)  # type: ignore[arg-type]
    other = disc_on_floor(0.5)
    for foreign in (of.Point(other.body("disc").point("center")), of.Body(other.body("disc"))):
        with pytest.raises(lf.ModelError, match=r"sensor: .* expected a part of this scene"):
            scene.sensor(foreign)
    assert scene.sensor(of.Energy()) == "sensor1"
    assert scene.sensor(of.Energy(name="E")) == "E"
    with pytest.raises(lf.ModelError, match="name: 'E' was given twice"):
        scene.sensor(of.Energy(name="E"))
    with pytest.raises(lf.ModelError, match="name: no sensor 'F', expected one of 'sensor1', 'E'"):
        lf.simulate(scene, 0.001, STEP).sensor("F")


def test_sections_and_stresses_off_the_body() -> None:
    for sensor, words in (
        (of.Section("bar", 0.7), "sensor 'sensor1': x: "),
        (of.Stress("bar", (0.2501, 0.005)), r"place: \(0.2501, 0.005\) was given, expected a place where stresses"),
    ):
        scene = struck_beam()
        scene.sensor(sensor)
        with pytest.raises(lf.ModelError, match=words):
            lf.simulate(scene, 0.001, STEP)


def test_a_function_that_fails_under_way_ends_the_run_and_loses_nothing() -> None:
    def falls(now: Any) -> float:
        if now.time > 0.0451:
            raise ValueError("too low")
        return float(now.q[1])

    scene = with_sensor(of.Function(falls, every=0.002, name="height"))
    scene.sensor(of.Energy(every=0.002, name="energy"))
    with pytest.raises(
        lf.StepError, match=r"sensor 'height': function: the function raised ValueError: 'too low'"
    ) as e:
        lf.simulate(scene, 0.1, STEP, record=0.01)
    result = e.value.result
    assert result is not None
    assert not result.complete
    height = result.sensor("height")
    np.testing.assert_allclose(height.times, np.arange(23) * 0.002, atol=1e-12)
    np.testing.assert_allclose(height.values[:, 0], 0.5 - 0.5 * 9.81 * height.times**2, atol=1e-9)
    assert len(result.sensor("energy").times) > 23


def test_a_function_that_is_interrupted_ends_the_run_there() -> None:
    def interrupted(now: Any) -> float:
        if now.time > 0.0451:
            raise KeyboardInterrupt
        return 0.0

    scene = with_sensor(of.Function(interrupted, every=0.002, name="slow"))
    result = lf.simulate(scene, 0.1, STEP, record=0.01)
    assert not result.complete
    assert result.message == "interrupted at t = 0.1 s"
    assert len(result.times) == 11


def test_a_run_that_fails_keeps_what_was_measured() -> None:
    def stops(t: float) -> float:
        if t > 0.05:
            raise ValueError("no force")
        return 0.0

    scene = disc_on_floor(0.5)
    scene.sensor(of.Body("disc", every=0.002, name="body"))
    scene.load(lf.Force(scene.body("disc").point("center"), (0.0, stops)))
    with pytest.raises(lf.StepError, match="no force") as e:
        lf.simulate(scene, 0.1, STEP, record=0.05)
    assert e.value.result is not None
    assert len(e.value.result.sensor("body").times) == 26


def test_a_pair_of_a_rule_by_its_name() -> None:
    scene = lf.Scene()
    for k in range(2):
        scene.add(lf.Disc(0.1, mass=1.0), f"disc{k + 1}", position=(0.0, 0.15 + 0.25 * k))
    scene.ground.half_plane((0.0, 0.0), (0.0, 1.0))
    scene.contact_all()
    scene.sensor(of.Contact("disc1.outline/disc2.outline", name="pair", every=0.002))
    scene.sensor(of.Contact("disc1.outline/ground.half_plane1", name="floor", every=0.002))
    result = lf.simulate(scene, 0.4, STEP, record=0.002)
    for name in ("pair", "floor"):
        sensor = result.sensor(name)
        contact = result.contact({"pair": "disc1.outline/disc2.outline"}.get(name, "disc1.outline/ground.half_plane1"))
        np.testing.assert_array_equal(sensor.times, result.times)
        np.testing.assert_array_equal(sensor.column("normal impulse"), contact.impulse[:, 0])
        np.testing.assert_array_equal(sensor.column("state"), contact.state)
        assert contact.impulse[-1, 0] > 0.0
