"""Sensors cost what they record."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping

import lcpflex as lf

STEP, DURATION = 1e-5, 0.6


def pendulum(every: float | None) -> lf.Scene:
    """The pendulum of the README, with ten sensors or none."""
    bar = lf.Beam(length=0.7, width=0.028, thickness=0.005, density=2700, youngs_modulus=6.9e10)
    scene = lf.Scene(gravity=(0, -9.81))
    body = scene.add(bar, name="pendulum", modes=8)
    scene.join(lf.Revolute(body.point("left"), scene.ground.at(0, 0), name="hinge"))
    stop = scene.ground.circle(center=(-0.0125, -0.69), radius=0.01)
    scene.contact(body.surface(), stop, friction=0.3, restitution=0.0, name="stop")
    if every is not None:
        of = lf.sensors
        for sensor in (
            *(of.Point(body.at(x, 0.0), every=every) for x in (0.1, 0.3, 0.5, 0.7)),
            of.Body(body, every=every), of.Coordinates(("pendulum.mode 1", "pendulum.mode 2"), every=every),
            of.Energy(every=every), of.Contact("stop", every=every), of.Reaction("hinge", every=every),
            of.Reaction("hinge", axes="body", every=every),
        ):  # fmt: skip
            scene.sensor(sensor)
    return scene


def seconds(every: float | None) -> float:
    """Of the processor, for a whole call: what other processes do at the same time does not count."""
    scene = pendulum(every)
    began = time.process_time()
    result = lf.simulate(scene, DURATION, lf.MoreauJean(step=STEP), progress=False)
    spent = time.process_time() - began
    assert len(result.sensors) == (0 if every is None else 10)
    assert all(len(sensor.times) == 6001 for sensor in result.sensors)
    return spent


def test_ten_sensors_at_a_tenth_of_the_steps(interleave: Callable[..., Mapping[str, float]]) -> None:
    medians = interleave({"without": lambda: seconds(None), "ten sensors": lambda: seconds(10.0 * STEP)})
    assert medians["ten sensors"] <= 1.2 * medians["without"]
