"""A claw: one or two driven fingers close on a wall that gives way."""

from __future__ import annotations

import math

from lcpflex.bodies.rigid import Box
from lcpflex.gallery.mechanisms.arguments import checked
from lcpflex.scene.joints.prismatic import Prismatic
from lcpflex.scene.joints.revolute import Revolute
from lcpflex.scene.loads.spring import Spring
from lcpflex.scene.loads.torque import Torque
from lcpflex.scene.scene import Scene

__all__ = ["TORQUE", "claw", "resting_force"]

TORQUE, WALL, DAMPING = 1.6, 1.0, 5.0  # [N m], [kg], [N s/m]: given
LENGTH, FINGER, WIDTH, NAIL = 0.8, 1.2, 0.03, 0.02  # of a finger [m], [kg], [m], radius at its tip [m]: chosen
THICKNESS, HEIGHT, ANCHOR = 0.1, 0.5, 1.0  # of the wall, and how far its spring reaches [m]: chosen
OPEN = (30.0, 60.0)  # angles at which the fingers are let go [degrees]: chosen


@checked
def claw(stiffness: float = 50.0, restitution: float = 0.0, fingers: int = 1) -> Scene:
    """Fingers, each turned by 1.6 N m, close on a wall of 1 kg on a spring [N/m] and a damper of 5 N s/m.

    With two fingers, the wall is between them. A finger is a uniform bar, 0.8 m long, of 1.2 kg, that meets the flat
    side of the wall with a round nail, and is at right angles to the wall's guide when it meets it at its place of
    rest. It starts at rest, opened by 30 degrees; the second by 60, so that it comes later. No gravity, no friction.
    After Silva et al.; all but torque, wall, spring, damper and restitution is chosen.
    """
    scene = Scene(gravity=(0.0, 0.0))
    wall = scene.add(Box(THICKNESS, HEIGHT, mass=WALL), name="wall")
    scene.join(Prismatic(wall.point("center"), scene.ground.at(0.0, 0.0), axis=(1.0, 0.0), name="guide"))
    anchor = scene.ground.at(0.5 * THICKNESS + ANCHOR, -0.5 * HEIGHT)
    scene.load(Spring(wall.at(0.5 * THICKNESS, -0.5 * HEIGHT), anchor, stiffness, DAMPING))
    for side, sign, opening in tuple(zip(("left", "right"), (-1.0, 1.0), OPEN, strict=True))[:fingers]:
        hinge = (sign * (0.5 * THICKNESS + NAIL), LENGTH)
        angle = sign * math.radians(opening)
        middle = (hinge[0] + 0.5 * LENGTH * math.sin(angle), hinge[1] - 0.5 * LENGTH * math.cos(angle))
        bar = Box(WIDTH, LENGTH, mass=FINGER)
        finger = scene.add(bar, name=f"{side} finger", position=middle, angle=angle)
        scene.join(Revolute(finger.point("top"), scene.ground.at(*hinge), name=f"{side} hinge"))
        scene.load(Torque(finger.point("top"), -sign * TORQUE))
        nail = finger.circle("bottom", NAIL)
        scene.contact(nail, wall.surface(side), restitution=restitution, name=side)
    return scene


def resting_force(stiffness: float = 50.0, fingers: int = 1) -> float:
    """Contact force when all is at rest [N].

    One finger at the angle a: F L cos a = T and F = k L sin a, so that sin 2a = 2 T/(k L^2); a spring of less than
    5 N/m does not hold it. Two hold each other, and the spring nothing: F = T/L.
    """
    if fingers == 2:
        return TORQUE / LENGTH
    angle = 0.5 * math.asin(2.0 * TORQUE / (stiffness * LENGTH**2))
    return TORQUE / (LENGTH * math.cos(angle))
