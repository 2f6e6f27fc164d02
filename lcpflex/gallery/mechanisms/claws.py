"""Claws: driven fingers close on walls that give way."""

from __future__ import annotations

import math

from lcpflex.bodies.rigid import Box, RigidBody
from lcpflex.errors import in_range
from lcpflex.gallery.mechanisms.arguments import checked
from lcpflex.scene.joints.prismatic import Prismatic
from lcpflex.scene.joints.revolute import Revolute
from lcpflex.scene.loads.spring import Spring
from lcpflex.scene.loads.torque import Torque
from lcpflex.scene.scene import Scene

__all__ = ["TORQUE", "claw", "claw_in_step", "resting_force"]

TORQUE, WALL, DAMPING = 1.6, 1.0, 5.0  # [N m], [kg], [N s/m]: given
LENGTH = 1.0  # of a finger, the stem [m]: given
FINGER, WIDTH, NAIL = 0.75, 0.03, 0.02  # of a finger [kg], [m], radius at its tip [m]: chosen
THICKNESS, HEIGHT, ANCHOR = 0.1, 0.5, 1.0  # of the wall, and how far its spring reaches [m]: chosen
OPEN = (30.0, 60.0)  # angles at which the fingers are let go [degrees]: chosen
CORE, TALL = 0.5, 2.4  # half the width of the block between two walls, and their height [m]: chosen


@checked
def claw(stiffness: float = 50.0, restitution: float = 0.0, fingers: int = 1) -> Scene:
    """Fingers, each turned by 1.6 N m, close on a wall of 1 kg on a spring [N/m] and a damper of 5 N s/m.

    With two fingers, the wall is between them. A finger is a uniform bar, 1 m long, of 0.75 kg, that meets the flat
    side of the wall with a round nail, and is at right angles to the wall's guide when it meets it at its place of
    rest. It starts at rest, opened by 30 degrees; the second by 60, so that it comes later. No gravity, no friction.
    After Silva et al., who print length, torque, wall, damper and restitution 0, and one spring of 10 N/m; the rest is
    chosen, for fingers that come one after the other. Their own model, with gravity and in step, is
    :func:`claw_in_step`.
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


@checked
def claw_in_step(stiffness: float = 10.0, mass: float = 1.0, gap: float = 0.2, gravity: float = 9.81) -> Scene:
    """Two fingers of 1 m, driven in step, close on the two sprung walls of a block: the claw of Silva et al.

    Each finger is a pendulum: it hangs at rest from its hinge, is turned towards its wall by 1.6 N m, and its tip
    meets the flat side of a wall of 1 kg, on a spring and a damper of 5 N s/m to the core of the block, without
    friction and with e = 0. With phi from the vertical, J = m L^2/3 and x the way of the wall:

        J phi'' + m g (L/2) sin phi = T - lambda L cos phi,    1 kg x'' + c x' + k x = lambda
        g_N = gap + x - L sin phi >= 0,    lambda >= 0,    g_N lambda = 0

    Nothing is shared by the two halves, which are mirror images of each other: what keeps them in step is that both
    begin alike.

    Printed in the paper: stem length 1 m, torque 1.6 N m, stiffness 10 N/m, wall 1 "Km", damping 5 "m/s" (read as kg
    and N s/m), e = 0. Chosen here, as it is not printed: the finger is a uniform bar, its ``mass`` and start, the
    ``gap``, and ``stiffness`` in the two other of the three cases that its text announces.

    Parameters
    ----------
    stiffness
        Of the spring of each wall [N/m].
    mass
        Of a finger [kg].
    gap
        Between the hanging finger and its wall at rest, in [0, 1] [m]: beyond, it never touches.
    gravity
        Acceleration of gravity [m/s^2].

    Raises
    ------
    ModelError
        For a number out of its range.
    """
    in_range("gap", gap, 0.0, LENGTH)
    scene = Scene(gravity=(0.0, -gravity))
    bar = RigidBody(mass, mass * LENGTH**2 / 12.0, points={"top": (0.0, 0.5 * LENGTH), "tip": (0.0, -0.5 * LENGTH)})
    for side, sign in (("left", -1.0), ("right", 1.0)):
        core = scene.ground.at(0.0, LENGTH)
        wall = scene.add(Box(THICKNESS, TALL, mass=WALL), name=f"{side} wall", position=(sign * CORE, LENGTH))
        scene.join(Prismatic(wall.point("center"), core, axis=(1.0, 0.0), name=f"{side} guide"))
        scene.load(Spring(wall.at(-sign * 0.5 * THICKNESS, 0.0), core, stiffness, DAMPING))
        hinge = sign * (CORE + 0.5 * THICKNESS + gap)
        finger = scene.add(bar, name=f"{side} finger", position=(hinge, 0.5 * LENGTH))
        scene.join(Revolute(finger.point("top"), scene.ground.at(hinge, LENGTH), name=f"{side} hinge"))
        scene.load(Torque(finger.point("top"), -sign * TORQUE))
        scene.contact(finger.node(0.0, -0.5 * LENGTH), wall.surface(side), restitution=0.0, name=side)
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
