"""A slider-crank of solids that meets a stop (Chen, Liu & Hong 2015, section 3.4), in space."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from lcpflex.bodies.solid import Solid
from lcpflex.bodies.spatial.rigid import Cuboid
from lcpflex.gallery.mechanisms.slider_cranks import COUPLER, CRANK, NOSE, SLIDER, SPRING, START, STOP, TOUCH, linkage
from lcpflex.gallery.mechanisms.solid_strikers import block, mirrored
from lcpflex.gallery.mechanisms.strikers import graded
from lcpflex.scene.joints.prismatic import Prismatic
from lcpflex.scene.joints.revolute import Revolute
from lcpflex.scene.joints.weld import Weld
from lcpflex.scene.loads.torsion_spring import TorsionSpring
from lcpflex.scene.spatial.handles import SpatialPlaced
from lcpflex.scene.spatial.joints.ball import Ball
from lcpflex.scene.spatial.scene import SpatialScene

__all__ = ["solid_slider_crank"]

ALUMINIUM: dict[str, Any] = {"density": 2700.0, "youngs_modulus": 7e10, "poissons_ratio": 0.33}
STEEL: dict[str, Any] = {"density": 7850.0, "youngs_modulus": 2.1e11, "poissons_ratio": 0.3}
WIDE, THICK, LEAF = 0.02, 0.005, 0.004  # of coupler and stop, and thickness of each [m]
FINE, REACH = 1e-3, 6e-3  # elements of the coupler where the stop may touch it, and half the length of that [m]
ACROSS = (0.0, 0.0, 1.0)  # axis of all hinges


def solid_slider_crank(
    coupler_modes: int = 12, stop_modes: int = 8, slider_modes: int = 2, law: Any | None = None
) -> SpatialScene:
    """The mechanism of :func:`~lcpflex.gallery.mechanisms.slider_cranks.slider_crank_with_stop` made of solids.

    Crank rigid; coupler, slider and stop of hexahedra. Dimensions, materials, spring, start and damping are those of
    the planar one. The nose of the stop is a round of 8 mm all over its width; the coupler, which has none, meets it
    with the middle of its lower face, at the same angle of the crank if nothing bends. ``law`` is that of the contact.
    The wrist pin is a ball joint and the slider is guided at its lower face: hinges alone would hold the mechanism in
    its plane three times.
    """
    scene = SpatialScene(gravity=(0.0, -9.8, 0.0))
    (x, y), tilt = linkage(START)
    arm = Cuboid(CRANK, 0.01, WIDE, density=2700.0)
    turned = Rotation.from_euler("z", START)
    crank = scene.add(arm, name="crank", position=(0.5 * x, 0.5 * y, 0.0), orientation=turned)
    way = np.array([np.cos(tilt), np.sin(tilt), 0.0])
    middle = np.array([x, y, 0.0]) + 0.5 * COUPLER * way
    leaning = Rotation.from_euler("z", tilt)
    coupler = scene.add(bar(), name="coupler", position=middle, orientation=leaning, modes=coupler_modes, damping=0.005)
    shoe = Solid.bar(SLIDER, 0.025, WIDE, elements=(12, 4, 4), **ALUMINIUM)
    place = (x + COUPLER * way[0] + 0.5 * SLIDER, 0.0, 0.0)
    slider = scene.add(shoe, name="slider", position=place, modes=slider_modes, damping=0.005)
    stop = cantilever(scene, stop_modes)

    bearing, origin = crank.at(-0.5 * CRANK, 0.0, 0.0), scene.ground.at(0.0, 0.0, 0.0)
    scene.join(Revolute(bearing, origin, axis=ACROSS, name="main bearing"))
    scene.join(Revolute(crank.at(0.5 * CRANK, 0.0, 0.0), coupler.point("left"), axis=ACROSS, name="crank pin"))
    scene.join(Ball(coupler.point("right"), slider.point("left"), name="wrist pin"))
    rail = scene.ground.at(place[0], -0.0125, 0.0)
    scene.join(Prismatic(slider.point("front"), rail, axis=(1.0, 0.0, 0.0), name="guide"))
    scene.load(TorsionSpring(bearing, origin, stiffness=SPRING, angle=0.0, axis=ACROSS))
    nose = stop.capsule((0.5 * STOP, 0.0, -0.5 * WIDE), (0.5 * STOP, 0.0, 0.5 * WIDE), NOSE)
    given = {} if law is None else {"law": law}
    scene.contact(coupler.face("contact"), nose, name="stop", **given)
    return scene


def bar() -> Solid:
    """The coupler, with small elements amid its lower face, "contact"; "middle" is the node in its middle."""
    along = mirrored(graded(0.5 * COUPLER, FINE, REACH, 0.0125, 1.5))
    mesh = block(along, np.linspace(-0.5, 0.5, 3) * THICK, np.linspace(-0.5, 0.5, 5) * WIDE)
    sets = {
        "contact": lambda x, y, z: (y < -0.499 * THICK) & (abs(x) < REACH + 0.1 * FINE),
        "middle": lambda x, y, z: x**2 + y**2 + z**2 < FINE**2 / 4.0,
    }
    return Solid(mesh, sets=sets, **ALUMINIUM)


def cantilever(scene: SpatialScene, modes: int) -> SpatialPlaced:
    """The stop, whose nose meets the coupler when the crank is at ``TOUCH``, if nothing bends."""
    leaf = Solid.bar(STOP, LEAF, WIDE, elements=(16, 2, 4), **STEEL)
    (x, y), tilt = linkage(TOUCH)
    below = 0.5 * THICK + NOSE  # from the middle of the coupler, at right angles to it
    tip = np.array([x + 0.5 * COUPLER * np.cos(tilt) + below * np.sin(tilt), 0.5 * y - below * np.cos(tilt), 0.0])
    stop = scene.add(leaf, name="stop", position=tip - [0.5 * STOP, 0.0, 0.0], modes=modes, damping=0.005)
    foot = scene.ground.at(*(tip - [STOP, 0.0, 0.0]).tolist())
    scene.join(Weld(stop.point("left"), foot, name="clamp"))
    return stop
