"""A slider-crank that meets a stop: three flexible bodies and a rigid crank (Chen, Liu & Hong 2015, section 3.4)."""

from __future__ import annotations

import math
from typing import TypeAlias

from lcpflex.bodies.beam import Beam
from lcpflex.bodies.rigid import Box
from lcpflex.gallery.mechanisms.arguments import checked
from lcpflex.scene.handles import Placed
from lcpflex.scene.joints.prismatic import Prismatic
from lcpflex.scene.joints.revolute import Revolute
from lcpflex.scene.joints.weld import Weld
from lcpflex.scene.loads.torsion_spring import TorsionSpring
from lcpflex.scene.scene import Scene

__all__ = ["COUPLER", "CRANK", "NOSE", "START", "TOUCH", "slider_crank_with_stop"]

Place: TypeAlias = tuple[float, float]

SPRING, START = 5.0, 0.29  # printed: coil spring [N m/rad] and first angle of the crank [rad]
WEIGHT = (0.0, -9.8)  # printed [m/s^2]
CRANK, COUPLER, SLIDER, STOP, NOSE = 0.15, 0.5, 0.08, 0.2, 0.008  # chosen: lengths and radius [m]
TOUCH = 0.1  # chosen: angle of the crank at the first touch, if nothing bends [rad]


@checked
def slider_crank_with_stop(coupler_modes: int = 10, stop_modes: int = 6, slider_modes: int = 2) -> Scene:
    """A slider-crank at rest that a coil spring drives towards its stretched position: its coupler meets a cantilever.

    Printed are: four bodies, the crank B1 rigid, B2, B3 and B4 flexible; contact between B3 and B4, a joint between B2
    and B3; the coil spring of 5 N m/rad, the first angle of 0.29 rad, gravity of 9.8 m/s^2, no friction. The text that
    is left does not say what B2, B3 and B4 are: here B3 is the coupler, B4 the cantilever and B2 the slider, which the
    wrist pin joins to the coupler. The table of dimensions is lost, these are chosen: crank 0.15 x 0.02 x 0.01 m,
    coupler 0.5 x 0.02 x 0.005 m and slider 0.08 x 0.02 x 0.025 m of aluminium (70 GPa, 2700 kg/m^3), stop
    0.2 x 0.02 x 0.004 m of steel (210 GPa, 7850 kg/m^3), noses of 8 mm radius on the middle of the coupler and on the
    tip of the stop, which meet at 0.1 rad, if nothing bends; modal damping 0.5 %.
    """
    scene = Scene(gravity=WEIGHT)
    pin, tilt = linkage(START)
    arm = Box(width=CRANK, height=0.01, mass=CRANK * 0.01 * 0.02 * 2700.0)
    crank = scene.add(arm, name="crank", position=(0.5 * pin[0], 0.5 * pin[1]), angle=START)
    bar = Beam(COUPLER, 0.02, 0.005, density=2700.0, youngs_modulus=7e10)
    coupler = scene.add(bar, "coupler", pin, tilt, modes=coupler_modes, damping=0.005)
    block = Beam(SLIDER, 0.02, 0.025, density=2700.0, youngs_modulus=7e10)
    slider = scene.add(block, "slider", (pin[0] + COUPLER * math.cos(tilt), 0.0), modes=slider_modes, damping=0.005)
    stop = cantilever(scene, stop_modes)

    bearing = crank.at(-0.5 * CRANK, 0.0)
    scene.join(Revolute(bearing, scene.ground.at(0.0, 0.0), name="main bearing"))
    scene.join(Revolute(crank.at(0.5 * CRANK, 0.0), coupler.point("left"), name="crank pin"))
    scene.join(Revolute(coupler.point("right"), slider.point("left"), name="wrist pin"))
    scene.join(Prismatic(slider.point("center"), scene.ground.at(0.0, 0.0), name="guide"))
    scene.load(TorsionSpring(bearing, scene.ground.at(0.0, 0.0), stiffness=SPRING, angle=0.0))
    scene.contact(coupler.circle("center", NOSE), stop.circle("right", NOSE), name="stop")
    return scene


def linkage(angle: float) -> tuple[Place, float]:
    """Crank pin [m] and inclination of the coupler [rad] of the rigid mechanism, its crank at ``angle`` [rad]."""
    pin = (CRANK * math.cos(angle), CRANK * math.sin(angle))
    return pin, -math.asin(pin[1] / COUPLER)


def cantilever(scene: Scene, modes: int) -> Placed:
    """The stop, whose nose that of the coupler meets when the crank is at ``TOUCH``, if nothing bends."""
    leaf = Beam(STOP, 0.02, 0.004, density=7850.0, youngs_modulus=2.1e11)
    pin, tilt = linkage(TOUCH)
    tip = (pin[0] + 0.5 * COUPLER * math.cos(tilt), 0.5 * pin[1] - 2.0 * NOSE)
    foot = (tip[0] - STOP, tip[1])
    stop = scene.add(leaf, "stop", foot, modes=modes, damping=0.005)
    scene.join(Weld(stop.point("left"), scene.ground.at(*foot), name="clamp"))
    return stop
