"""A pendulum strikes a rod, both solids: the spot of contact of Chen, Liu & Hong 2015, figures 5 to 7, 9 and 10.

A steel pendulum with a round nose meets the end of an aluminium rod at 1 m/s. Printed are the materials by name, a
circle of contact of 0.8 mm, 30 kHz, elements of 8.5 mm and a quarter of that along the impact, 0.6 mm in the contact
region of the first of four meshes, 20 modes a body, 2 ms. All lengths, the speed and the tables are lost; those chosen
(``lcpflex.gallery.mechanisms.solid_strikers``) give a circle of 0.78 mm. So curves cannot be compared, but what the
text says of them can. Forces and velocities are shown as means over 10 us.

- Figures 6 and 7, "different sets of contact stiffness will lead to totally different results" until they converge to
  the multipliers' (nodal coordinates in the contact region, modes of the rest, both by Craig and Bampton): springs of
  10^6, 3 10^6 and 10^7 N/m a node give 11, 5 and 1.9 % too much impulse, and velocities off by 14, 6.5 and 2.5 % of the
  speed. Moreau's steps over nodes with mass and a massless boundary agree within 0.1 % of the impulse.
- Figure 5, "sufficiently precise" with 20 modes a body: with 20 of the pendulum and 30 of the rod the velocity is off
  by 1.6 % of the speed over 2 ms, the peak force by 1.4 %. Half of these modes bend the other way, or twist.
- Figures 9 and 10, "significant influence" of the mesh: with 0.6 mm in the contact region 9 nodes close, where 21 do of
  0.28 mm: the collision lasts 1.2 % longer and its peak is 1.2 % higher. Along the impact, two layers of 10 mm put the
  velocity behind off by 5 %; ten of 2 mm, a quarter of 8.5 mm, by 0.3 %: their rule 2. The force hardly feels either.
"""

from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

import lcpflex as lf
from lcpflex.gallery.mechanisms.solid_strikers import (
    FINE as SIZE,
    REACH,
    solid_pendulum,
    solid_pendulum_and_rod,
    solid_rod,
)
from lcpflex.jit.kernel import FloatArray

WINDOW = 1e-5  # velocities and forces are shown as means over it [s]
PUSH, LONG = 4.6e-4, 2e-3  # the collision, and what they show [s]
MODES, ROD_MODES = 40, 60  # half of those of the rod bend it the other way, or twist it
SPRINGS = {"10⁶": (1e6, 1e-7), "3·10⁶": (3e6, 5e-8), "10⁷": (1e7, 2.5e-8)}  # [N/m], step [s]
MULTIPLIERS, MASSLESS = "multipliers, nodes kept", "multipliers, massless boundary"
FINE = "4 fine: 0.28, 8.5 mm"
MESHES: dict[str, Any] = {
    "1 contact region: 0.6 mm": {"fine": 6e-4},
    "2 direction of impact: 10 mm": {"layers": 2},
    "3 direction of impact: 2 mm": {"layers": 10},
    FINE: {},
}


pendulum, rod = cache(solid_pendulum), cache(solid_rod)  # factors of a mesh serve several reductions of it


def with_residual_modes(modes: tuple[int, int], mesh: str) -> list[lf.SpatialBody]:
    """Free modes, and residual modes of the forces at hinge and contact."""
    hinge = lf.Interface("hinge", contact=False)
    options: Any = {"contact": "contact", "rows": "normal"}
    swinging = pendulum(**MESHES[mesh]).reduce(modes[0], interfaces=[hinge], **options)
    return [swinging, rod().reduce(modes[1], **options)]


def with_nodes_kept() -> list[lf.SpatialBody]:
    """Both by Craig and Bampton: the normal displacements of the contact region, and modes of the rest."""
    solids = (pendulum(), MODES), (rod(), ROD_MODES)
    return [solid.reduce(modes, boundary="contact", rows="normal") for solid, modes in solids]


def strike(modes: tuple[int, int] = (MODES, ROD_MODES), mesh: str = FINE, duration: float = PUSH) -> lf.Result:
    """Over a massless boundary."""
    scene = solid_pendulum_and_rod(*with_residual_modes(modes, mesh))
    return lf.simulate(scene, duration, lf.MasslessBoundary(step=1e-6), record=1e-6)


def by_multipliers(bodies: list[lf.SpatialBody]) -> lf.Result:
    return lf.simulate(solid_pendulum_and_rod(*bodies), PUSH, lf.MoreauJean(step=4e-7), record=2e-6)


def by_penalty(bodies: list[lf.SpatialBody], spring: float, step: float) -> lf.Result:
    """``spring`` [N/m] is that of a node; the law of a face is shared by its nodes as its area is."""
    elements = (2 * round(REACH / SIZE)) ** 2
    scene = solid_pendulum_and_rod(*bodies, law=lf.Penalty(spring * elements))
    return lf.simulate(scene, PUSH, lf.MoreauJean(step=step), record=2e-6)


def mean_rate(result: lf.Result, values: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Times [s], and the mean rate over ``WINDOW`` of a quantity at the instants of a result."""
    times = np.arange(0.0, result.times[-1] - WINDOW, 0.2 * WINDOW)
    before, after = (np.interp(at, result.times, values) for at in (times, times + WINDOW))
    return times + 0.5 * WINDOW, (after - before) / WINDOW


def velocity_behind(result: lf.Result) -> tuple[FloatArray, FloatArray]:
    """Of the point right behind the contact, along the impact [m/s]."""
    return mean_rate(result, result.point("pendulum", "back")[:, 0])


def contact_force(result: lf.Result) -> tuple[FloatArray, FloatArray]:
    """[N]."""
    return mean_rate(result, result.contact("strike").impulse[:, 0])


def apart(result: lf.Result, other: lf.Result, until: float = PUSH) -> float:
    """Root mean square difference of two velocities behind the contact up to a time, by the speed of approach."""
    (times, one), (others, two) = velocity_behind(result), velocity_behind(other)
    return float(np.sqrt(np.mean((one - np.interp(times, others, two))[times < until] ** 2)))


def collision(result: lf.Result) -> tuple[float, float, float]:
    """When it ends [s], its largest force [N] and its impulse [N s], within ``PUSH``."""
    hit = result.contact("strike")
    k = int(np.searchsorted(result.times, PUSH + 1e-9)) - 1
    force = hit.normal_force[: k + 1]
    return float(result.times[np.flatnonzero(force)[-1]]), float(force.max()), float(hit.impulse[k, 0])


def check(
    kept: lf.Result, springs: dict[str, lf.Result], meshes: dict[str, lf.Result], modes: dict[str, lf.Result]
) -> None:
    """What the text of the paper says of the figures."""
    fine = meshes[FINE]
    assert abs(collision(kept)[2] / collision(fine)[2] - 1.0) < 2e-3
    off = [apart(result, kept) for result in springs.values()]
    assert off == sorted(off, reverse=True)
    assert off[-1] < 0.03 < 0.1 < off[0]
    few, deep, quarter, _ = meshes.values()
    assert few.contact("strike").pairs.max() == 9 < 15 < fine.contact("strike").pairs.max()
    assert apart(quarter, fine) < 0.005 < 0.03 < apart(deep, fine)
    small, large = modes.values()
    assert apart(small, large, LONG) < 0.02


def draw(axes: Axes, results: dict[str, lf.Result], shown: str, until: float) -> None:
    """``shown``: "force" or "velocity"; the last result in black."""
    for number, (name, result) in enumerate(results.items()):
        last = number == len(results) - 1
        times, values = contact_force(result) if shown == "force" else velocity_behind(result)
        look = {"color": "black", "linewidth": 1.6} if last else {"color": f"C{number}", "linewidth": 1.0}
        axes.plot(1e6 * times, values, label=name, **look)
    label = "contact force [N]" if shown == "force" else "velocity behind the contact [m/s]"
    axes.set(xlabel="time [µs]", ylabel=label, xlim=(0.0, 1e6 * until))
    axes.legend(fontsize="small")
    axes.grid(True, alpha=0.4)


def run(folder: Path = Path()) -> lf.Result:
    bodies = with_nodes_kept()
    kept = by_multipliers(bodies)
    springs = {f"penalty {name} N/m a node": by_penalty(bodies, *given) for name, given in SPRINGS.items()}
    meshes = {name: strike(mesh=name) for name in MESHES}
    modes = {f"{n} and {3 * n // 2} modes": strike((n, 3 * n // 2), duration=LONG) for n in (20, MODES)}
    massless = meshes[FINE]
    check(kept, springs, meshes, modes)

    figure = Figure(figsize=(15, 8), layout="constrained")
    panels = figure.subplots(2, 3)
    draw(panels[0, 0], {**springs, MASSLESS: massless, MULTIPLIERS: kept}, "force", PUSH)
    draw(panels[1, 0], {**springs, MASSLESS: massless, MULTIPLIERS: kept}, "velocity", PUSH)
    draw(panels[0, 1], meshes, "force", PUSH)
    draw(panels[1, 1], meshes, "velocity", PUSH)
    draw(panels[0, 2], modes, "velocity", LONG)
    draw(panels[1, 2], modes, "velocity", PUSH)
    titles = ("springs and multipliers (figures 6, 7)", "meshes of the pendulum (figures 9, 10)", "modes (figure 5)")
    for axes, title in zip(panels[0], titles, strict=True):
        axes.set_title(title)
    figure.savefig(folder / "solid_pendulum_strikes_rod.png", dpi=110)
    return massless


if __name__ == "__main__":
    print(run().summary())
