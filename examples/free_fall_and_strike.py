"""A flexible pendulum falls, and strikes: the four figures of a paper, and what its text says of them.

The strip of ``flexible_pendulum_micro_collisions`` in the order of Shi, Hong & Liu 2013, figures 5 to 8. Printed are
sizes and material, the release at rest from the level, the 0.4 m/s at which it meets the hemisphere, and the ranges of
the axes; the places of P and of the hemisphere and its radius are not. P is taken as the free end, the frame as the one
at the centre of mass (the frame of Buckens), and the strike is that of ``gallery.mechanisms.strikers``, 0.665 m from
the hinge and with a radius of 0.1 m. Theirs is a solid in space, ours one in the plane.

- Figures 5 and 6, 0.1 s of free fall. "The acceleration is approximately constant", "nearly a straight line which is
  the result of rigid body", but "point P and floating frame do not maintain absolute uniform acceleration". So it is:
  the lines of uniform acceleration are met within 3 % of the last value by the end and 1.4 % by the frame. A rigid bar
  differs from them by 0.7 %, by an arc, and the flexible one from the rigid one by a ripple of 2.6 and 0.9 %. Their
  axes end at -1.8 m/s for P, which agrees with our -1.49, and, as far as they are left, at -0.5 m/s for the frame,
  which does not: the centre of mass comes to -0.73 m/s, and -0.5 m/s is 0.24 m from the hinge. Where their frame lies
  is not said.
- Figure 7, "three collisions". There are three, from 0 to 34, 65 to 101 and 141 to 175 us; none follows within their
  1.5 ms. The first has a peak of 706 N, above their axis of 500 N; which is right for their bar nobody can tell without
  place and radius.
- Figure 8, "the point out of contact region also has an impact due to the stress wave". The point of the upper face
  above the contact is still at -0.37 m/s after 1 us (-0.35 with 320 modes: the front of a pressure wave, which takes
  0.93 us through 5 mm, is made of the highest), comes to rest after 3.6 us, moves to and fro with each collision, and
  stays between -0.4 and 0.22 m/s, within their axis of 0.4 m/s either way.
- "The modal description can not simulate the collision response with such high frequency": by 20 free modes alone there
  is one contact of 0.2 ms, all of the cross-section stops with its lower face at once, and rests as long as it touches.
"""

from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

import lcpflex as lf
from lcpflex import gallery
from lcpflex.gallery.acceptance.measures import separate_contacts
from lcpflex.gallery.mechanisms.strikers import pendulum_on_hemisphere, strip_with_patch
from lcpflex.jit.kernel import FloatArray

LENGTH, GRAVITY = 0.7, 9.81
PARTED = 1e-5  # shorter openings part nothing [s]


def fall(modes: int = 8) -> lf.Result:
    """0.1 s from rest, level."""
    return lf.simulate(gallery.pendulum(modes=modes, friction=0.0), 0.1, lf.EventDriven(), record=1e-4)


def frame_velocity(result: lf.Result) -> FloatArray:
    """Upward velocity of the frame at the centre of mass, v + omega x s [m/s]; that of the beam is at its left end."""
    first = result.coordinate_names().index("pendulum.x")
    speed, spin = result.u[:, first + 1], result.u[:, first + 2]
    return np.asarray(speed + 0.5 * LENGTH * spin * np.cos(result.q[:, first + 2]))


def end_velocity(result: lf.Result) -> FloatArray:
    """Upward velocity of the free end [m/s]."""
    return result.velocity("pendulum", "right")[:, 1]


def strike(modes: int, duration: float, nodal: bool = True) -> lf.Result:
    """The strike, by nodes of the contact region and ``modes`` of the rest, or by ``modes`` alone."""
    scene = pendulum_on_hemisphere(strip_with_patch(), modes, nodal=nodal)
    stepper = lf.MasslessBoundary(step=2e-7, dynamic_modes=modes) if nodal else lf.MoreauJean(step=1e-7)
    return lf.simulate(scene, duration, stepper, record=2e-7)


def velocity_behind(result: lf.Result) -> FloatArray:
    """Upward velocity of the point of the upper face above the contact [m/s]."""
    return result.velocity("pendulum", "back")[:, 1]


def shaken(result: lf.Result) -> float:
    """Range of that velocity from 10 to 150 microseconds after the touch [m/s]."""
    shown = (result.times > 1e-5) & (result.times < 1.5e-4)
    return float(np.ptp(velocity_behind(result)[shown]))


def check(falling: lf.Result, rigid: lf.Result, nodal: lf.Result, modal: lf.Result) -> None:
    """What the text of the paper says of its figures."""
    for slope, of in ((-0.75 * GRAVITY, frame_velocity), (-1.5 * GRAVITY, end_velocity)):
        flexible, bar, last = of(falling), of(rigid), abs(0.1 * slope)
        assert np.abs(flexible - slope * falling.times).max() < 0.035 * last  # nearly straight
        assert 0.005 * last < np.abs(flexible - np.interp(falling.times, rigid.times, bar)).max()  # but not quite
    assert len(separate_contacts(nodal, PARTED)) == 3
    behind = velocity_behind(nodal)
    assert behind.min() > -0.401
    assert 0.0 < behind.max() < 0.4
    assert len(separate_contacts(modal, PARTED)) == 1
    assert shaken(modal) < 0.05 * shaken(nodal)


def draw_fall(axes: Axes, times: FloatArray, velocity: FloatArray, slope: float, label: str) -> None:
    axes.plot(times, velocity, label="flexible, 8 modes")
    axes.plot(times, slope * times, "k--", linewidth=1.0, label=f"uniform, {slope / GRAVITY:g} g t")
    axes.set(xlabel="time [s]", ylabel=label)
    axes.legend()


def run(folder: Path = Path(), modes: int = 160) -> lf.Result:
    """``modes`` of the strip that has nodes in its contact region."""
    falling, nodal, modal = fall(), strike(modes, 1.5e-3), strike(20, 1.5e-3, nodal=False)
    check(falling, fall(modes=0), nodal, modal)

    figure = Figure(figsize=(12, 8), layout="constrained")
    (frame, end), (force, behind) = figure.subplots(2, 2)
    draw_fall(frame, falling.times, frame_velocity(falling), -0.75 * GRAVITY, "velocity of the frame [m/s]")
    draw_fall(end, falling.times, end_velocity(falling), -1.5 * GRAVITY, "velocity of the end [m/s]")
    force.plot(1e3 * nodal.times, nodal.contact("hemisphere").force[:, 0])
    force.set(xlabel="time since touch [ms]", ylabel="contact force [N]")
    inset = behind.inset_axes((0.42, 0.1, 0.55, 0.32))
    for axes, scale in ((behind, 1e3), (inset, 1e6)):  # an inset with the first collision
        axes.plot(scale * modal.times, velocity_behind(modal), "C1", linewidth=1.0, label="20 modes alone")
        axes.plot(scale * nodal.times, velocity_behind(nodal), "C0", linewidth=1.0, label=f"nodes and {modes} modes")
    inset.set(xlim=(0.0, 40.0))
    inset.set_title("the first 40 µs", fontsize="medium")
    behind.set(xlabel="time since touch [ms]", ylabel="velocity behind the contact [m/s]", ylim=(-1.1, 0.45))
    behind.legend(loc="upper right")
    for axes, number in ((frame, 5), (end, 6), (force, 7), (behind, 8)):
        axes.set_title(f"figure {number}")
        axes.grid(True, alpha=0.4)
    figure.savefig(folder / "free_fall_and_strike.png", dpi=110)
    return nodal


if __name__ == "__main__":
    print(run().summary())
