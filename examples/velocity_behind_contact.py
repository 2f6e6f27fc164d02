"""What is felt right behind the place that is struck: how many modes, how stiff a spring, how fine a mesh?

The pendulum of ``pendulum_strikes_rod`` strikes its rod; looked at is the velocity, along the line of impact, of the
point of the pendulum right behind the contact: figures 5, 7 and 10 of Chen, Liu & Hong 2015, with the contact forces of
their figures 6 and 9. Printed are 2 ms, 30 kHz, 8.5 mm, contact elements of 0.6 mm in the coarsest mesh, which make 4
pairs where at least 9 are needed, and a quarter of the element size in the direction of impact. Dimensions, speeds and
the curves are lost; ours are planar and chosen, so that what can be compared is what their text says of the curves.
All are shown as means over 10 us, which keep 86 % of what swings at 30 kHz, and nothing at 100 kHz.

- Figure 5, "sufficiently precise" with a small part of the coordinates (153 nodes and 20 modes for 2261, 128 and 20 for
  5373). Here 17 nodes and 40 modes stand for the 3410 nodes of the rod, 19 and 40 for the 1704 of the pendulum, and the
  velocity is that of 80 modes within 0.8 % of the speed of approach for 1.6 ms, when the bodies meet again, 3 % over
  2 ms. With 20 modes it is 10 % off, by a ripple of 35 kHz: for our planar bodies 20 are too few.
- Figures 6 and 7, "different sets of contact stiffness will lead to totally different results", which converge to the
  Lagrangian ones: 10^7 N/m a pair is off by 13 % of the speed, 10^8 by 3, 10^9 by 0.8, 10^10 by 0.1 %.
- Figures 9 and 10, "significant influence" of the element size, of the interior "not only on the wave propagation, but
  also on the contact force". Here the interior does most: with 20 mm the velocity is off by 6 % and the peak force by
  7 %; 6 mm in the direction of impact make 3 and 2 %. Too few contact pairs, 4 instead of 10, do least, 1.3 and 1.2 %,
  in this contact along a line; theirs is a spot.
"""

import warnings
from functools import cache
from pathlib import Path
from typing import TypeAlias

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

import lcpflex as lf
from lcpflex.gallery.mechanisms.strikers import FINE, pendulum_and_rod, pendulum_with_hammer, rod_with_crown
from lcpflex.jit.kernel import FloatArray

SPEED = 1.4  # of approach [m/s]
WINDOW = 1e-5  # velocities and forces are shown as means over it [s]
PUSH, SHORT, LONG = 1.8e-4, 3e-4, 2e-3  # the first push, with what follows, and in all [s]
Mesh: TypeAlias = tuple[float, float, int | None]

LAGRANGE = "Lagrangian: event-driven, e = 0"
FINEST: Mesh = (FINE, 3.5e-3, None)
MESHES: dict[str, Mesh] = {  # of the pendulum: elements where it touches and elsewhere [m], layers along the impact
    "1 contact region: 1.2 mm": (1.2e-3, 3.5e-3, None),
    "2 direction of impact: 6 mm": (FINE, 3.5e-3, 2),
    "3 interior: 20 mm": (FINE, 20e-3, None),
    "4 fine: 0.3, 2.5 and 3.5 mm": FINEST,
}


@cache
def scene(modes: int, mesh: Mesh) -> lf.Scene:
    """The strike; nodes of the pendulum meet edges of the rod, so that its mesh makes the pairs."""
    fine, coarse, layers = mesh
    return pendulum_and_rod(
        rod_with_crown(),
        pendulum_with_hammer(fine, coarse, layers=layers),
        lambda body, kept: lf.craig_bampton(body, kept, modes=modes, damping=lf.Rayleigh(0.0, 1e-9)),
        speed=SPEED,
        node_side="pendulum",
    )


def strike(modes: int, duration: float, stepper: object | None = None, mesh: Mesh = FINEST) -> lf.Result:
    """By the massless boundary, unless another stepper is given."""
    stepper = lf.MasslessBoundary(step=1e-7, dynamic_modes=modes) if stepper is None else stepper
    return lf.simulate(scene(modes, mesh), duration, stepper, record=1e-6)


def velocity_behind(result: lf.Result) -> tuple[FloatArray, FloatArray]:
    """Times [s] and mean velocity over ``WINDOW`` in the direction of impact, of the point behind the contact [m/s]."""
    return mean_rate(result, result.point("pendulum", "back")[:, 0])


def contact_force(result: lf.Result) -> tuple[FloatArray, FloatArray]:
    """Times [s] and mean contact force over ``WINDOW`` [N]: impulses count in it as forces do."""
    return mean_rate(result, result.contact("strike").impulse[:, 0])


def mean_rate(result: lf.Result, values: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Of a quantity at the instants of a result."""
    times = np.arange(0.0, result.times[-1] - WINDOW, 0.2 * WINDOW)
    before, after = (np.interp(at, result.times, values) for at in (times, times + WINDOW))
    return times + 0.5 * WINDOW, (after - before) / WINDOW


def apart(result: lf.Result, other: lf.Result, until: float) -> float:
    """Root mean square difference of two velocities behind the contact up to a time [s], by the speed of approach."""
    (times, one), (others, two) = velocity_behind(result), velocity_behind(other)
    difference = (one - np.interp(times, others, two))[times < until]
    return float(np.sqrt(np.mean(difference**2)) / SPEED)


def by_modes() -> dict[str, lf.Result]:
    """Figure 5."""
    return {f"{modes} modes": strike(modes, LONG) for modes in (20, 40, 80)}


def by_springs() -> dict[str, lf.Result]:
    """Figures 6 and 7: the penalty law with ever stiffer springs, and the Lagrangian method."""
    bodies = scene(40, FINEST)
    highest = np.sqrt(max(bodies.body(name).source.stiffness.max() for name in ("rod", "pendulum")))
    results = {}
    for k, exponent in zip((1e7, 1e8, 1e9, 1e10), ("⁷", "⁸", "⁹", "¹⁰"), strict=True):
        integrator = lf.Verlet(min(1.8, 0.95 * np.sqrt(1e10 / k)) / highest)
        results[f"penalty 10{exponent} N/m"] = strike(40, PUSH, lf.Smooth(lf.Penalty(k), integrator=integrator))
    return {**results, LAGRANGE: strike(40, PUSH, lf.EventDriven(rtol=1e-4, atol=1e-7))}


def by_meshes() -> dict[str, lf.Result]:
    """Figures 9 and 10; the third mesh is far too stiff in bending, and warns."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", lf.ModelWarning)
        return {name: strike(40, SHORT, mesh=mesh) for name, mesh in MESHES.items()}


def check(modes: dict[str, lf.Result], springs: dict[str, lf.Result], meshes: dict[str, lf.Result]) -> None:
    """What the text of the paper says of the figures, as far as it is so here."""
    rich, exact, fine = modes["80 modes"], springs[LAGRANGE], meshes[list(MESHES)[-1]]
    assert apart(modes["40 modes"], rich, 1.6e-3) < 0.015 < 0.05 < apart(modes["20 modes"], rich, 1.6e-3)
    off = [apart(result, exact, PUSH) for name, result in springs.items() if name != LAGRANGE]
    assert off == sorted(off, reverse=True)
    assert off[-1] < 0.005 < 0.1 < off[0]
    coarse = [result for result in meshes.values() if result is not fine]
    assert min(apart(result, fine, SHORT) for result in coarse) > 0.01
    pairs = [result.contact("strike").pairs.max() for result in meshes.values()]
    assert pairs[0] <= 4 < 9 <= pairs[-1]


def draw(column: list[Axes], results: dict[str, lf.Result], until: float, below: str) -> None:
    """Velocity behind the contact above, and below the same in its first 0.3 ms, or the contact force."""
    for number, (name, result) in enumerate(results.items()):
        last = number == len(results) - 1
        look = {"color": "black" if last else f"C{number}", "linewidth": 1.6 if last else 1.0, "label": name}
        times, velocity = velocity_behind(result)
        column[0].plot(1e3 * times, velocity, **look)
        times, shown = (times, velocity) if below == "velocity" else contact_force(result)
        column[1].plot(1e6 * times, shown, **look)
    column[0].set(xlabel="time [ms]", ylabel="velocity behind the contact [m/s]", xlim=(0.0, 1e3 * until))
    label = "the same, its beginning [m/s]" if below == "velocity" else "contact force [N]"
    column[1].set(xlabel="time [µs]", ylabel=label, xlim=(0.0, min(1e6 * until, 300.0)))
    column[0].legend()
    for axes in column:
        axes.grid(True, alpha=0.4)


def run(folder: Path = Path()) -> lf.Result:
    modes, springs, meshes = by_modes(), by_springs(), by_meshes()
    check(modes, springs, meshes)

    figure = Figure(figsize=(15, 8), layout="constrained")
    panels = figure.subplots(2, 3)
    for column, results, until, title, below in (
        (panels[:, 0], modes, LONG, "modes (figure 5)", "velocity"),
        (panels[:, 1], springs, PUSH, "contact springs (figures 6 and 7)", "force"),
        (panels[:, 2], meshes, SHORT, "meshes of the pendulum (figures 9 and 10)", "force"),
    ):
        draw(list(column), results, until, below)
        column[0].set_title(title)
    figure.savefig(folder / "velocity_behind_contact.png", dpi=110)
    return springs[LAGRANGE]


if __name__ == "__main__":
    print(run().summary())
