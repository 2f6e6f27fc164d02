"""The strip of Shi, Hong & Liu 2013 as a solid in space: a mesh with a fine face where it strikes, and its scene."""

from __future__ import annotations

from lcpflex.bodies.reduction.interface import Interface
from lcpflex.bodies.solid import Solid
from lcpflex.bodies.spatial.body import SpatialBody
from lcpflex.gallery.mechanisms.arguments import checked
from lcpflex.scene.joints.revolute import Revolute
from lcpflex.scene.spatial.scene import SpatialScene

__all__ = ["SIZES", "hinged_solid", "solid_on_hemisphere", "solid_strip"]

SIZES = (0.7, 0.028, 0.005)  # of the strip of Shi, Hong & Liu 2013 [m]
FINEST, REACH = 1.5e-4, 5.5e-4  # of elements at the contact, and of the face around it [m]: Hertz's radius is .37 mm
GROWTH = 2.0  # of elements from there on


@checked
def solid_strip(reach: float = 0.63, size: float = 7e-3, finest: float = FINEST, growth: float = GROWTH) -> Solid:
    """The strip of Shi, Hong & Liu 2013 in aluminium, flat and along x, about the origin; thickness along z.

    The face "patch" is below it at ``reach`` [m] from the left end, in the middle of the width, for contacts of a
    radius up to half a millimetre: 260 N on a sphere of 20 mm. "back" is the point of the upper face right above it.
    Poisson's ratio, which they do not print, is 0.33.

    reach: [m]. size: longest edge of an element [m]; the shortest wave of 80 modes, 43 mm, takes six. finest, growth :
    of elements at the patch [m], and from one to the next beyond it.
    """
    length, _, thickness = SIZES
    x0, z0 = reach - 0.5 * length, 0.5 * thickness
    return Solid.box(
        SIZES, size, near={"patch": ((x0, 0.0, -z0), finest, REACH, growth)}, density=2700.0, youngs_modulus=6.9e10,
        poissons_ratio=0.33, sets={"back": lambda x, y, z: abs(x - x0) + abs(y) + abs(z - z0) < 0.1 * finest},
    )  # fmt: skip


def hinged_solid(solid: Solid, modes: int = 80) -> SpatialBody:
    """Free modes, and residual ones of the hinge at its face "left" and of normal forces at the nodes of "patch".

    modes : half of them bend the wide way or twist.
    """
    hinge = Interface("left", contact=False)
    return solid.reduce(modes, contact="patch", rows="normal", interfaces=[hinge])


def solid_on_hemisphere(
    body: SpatialBody,
    reach: float = 0.63,
    radius: float = 0.02,
    speed: float = 0.4,
    gap: float = 1e-9,
    points: str | None = None,
) -> SpatialScene:
    """A :func:`hinged_solid`, straight and level, meets a fixed sphere with its patch. No gravity.

    Parameters
    ----------
    body : of a :func:`solid_strip`
    reach : of the patch from the hinge [m], that of the strip
    radius : of the sphere [m]
    speed : there [m/s]
    gap : at the start [m]
    points : of the patch that touch, "nodes" or "areas"; None for the default
    """  # fmt: skip
    length, _, thickness = SIZES
    scene = SpatialScene(gravity=(0.0, 0.0, 0.0))
    spin = speed / reach
    strip = scene.add(
        body, name="pendulum", angular_velocity=(0.0, spin, 0.0), velocity=(0.0, 0.0, -0.5 * spin * length)
    )
    hinge = scene.ground.at(-0.5 * length, 0.0, 0.0)
    scene.join(Revolute(strip.point("left"), hinge, axis=(0.0, 1.0, 0.0), name="hinge"))
    ball = scene.ground.sphere((reach - 0.5 * length, 0.0, -0.5 * thickness - radius - gap), radius)
    scene.contact(strip.face("patch"), ball, points=points, name="hemisphere")
    return scene
