"""A snap-fit hook is pushed over a rib and pulled back: forces of insertion and retention, the stress at their peak.

An arm of plastic, 20 mm long and 2 mm thick, has a nose of 1 mm at its end: a ramp of 18 degrees in front, 45 degrees
at the back. A drive moves its root along a guide, 8 mm towards a rib (r = 0.5 mm, 0.9 mm in the way) and back.

*At rest* (lines): ``lf.path(scene, "drive", values)``, from rest to rest, each from the one before: the drive goes as
slowly as one likes, and friction counts slip.
*In time* (thin): the same at 0.1 m/s. They are the same but for vibrations of the arm. Where the nose slides off the
rib, the force of the drive turns within half a millimetre; the path has no jump there, as the root is held.

The root is held at all its nodes, each by a hinge on a rigid carriage: a weld at a single node would let the mesh turn
about it, by 3 % of the force here. The rib touches anywhere on the nose, so the scene is reduced with residual modes
there (``modes=8`` does so). Reference (in the tests): a static finite-element solution with large displacements, the
same mesh, within 2 % on the whole ramp. Linear finite elements are 6 % off at its end, and the beam formula

    F = P (mu + tan a) / (1 - mu tan a),    P = 3 E I y / L^3

is further: a is that of the ramp as it has turned with the arm, the root gives way, and L is short for a beam.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.tri import Triangulation

import lcpflex as lf
from lcpflex.jit.kernel import FloatArray

LENGTH, HEIGHT, THICKNESS = 20e-3, 2e-3, 5e-3  # of the arm [m]
PLASTIC = {"density": 1050.0, "youngs_modulus": 2.3e9, "poissons_ratio": 0.38}
ALONG = np.array([0.0, 15.5e-3, 16.5e-3, 17e-3, LENGTH])  # upper side: the arm, the back of the nose, its top, the ramp
ABOVE = np.array([1e-3, 1e-3, 2e-3, 2e-3, 1e-3])
ELEMENTS = (16, 2, 1, 6)  # along each of these
RIB, RADIUS = (21e-3, 1.6e-3), 0.5e-3  # centre and radius [m]
STROKE, SPEED = 8e-3, 0.1  # [m], and of the run in time [m/s]
STEP = 0.25e-3  # from rest to rest [m]
FRICTION = (0.0, 0.3)


def mesh() -> Any:
    """Two layers of quadratic quadrilaterals; boundaries "root" and "top"."""
    parts = [np.linspace(a, b, n, endpoint=False) for a, b, n in zip(ALONG[:-1], ALONG[1:], ELEMENTS, strict=True)]
    flat = lf.meshes.grid(np.concatenate([*parts, [LENGTH]]), [-0.5 * HEIGHT, 0.0, 0.5 * HEIGHT], order=1)
    x, y = flat.p
    share = (y + 0.5 * HEIGHT) / HEIGHT
    bent = type(flat)(np.stack([x, share * (np.interp(x, ALONG, ABOVE) + 0.5 * HEIGHT) - 0.5 * HEIGHT]), flat.t)
    ends = {
        "root": lambda at: at[0] == 0.0,
        "top": lambda at: at[1] > np.interp(at[0], ALONG, ABOVE) - 1e-9,
    }
    return lf.meshes.quadratic(bent.with_boundaries(ends))


def scene(friction: float, motion: Any, speed: float = 0.0) -> lf.Scene:
    """Hook, carriage and rib; ``motion`` is that of the drive [m], which begins with ``speed`` [m/s]."""
    made = lf.Scene(gravity=(0.0, 0.0))
    body = lf.Continuum(mesh(), **PLASTIC, thickness=THICKNESS)
    hook = made.add(body, "hook", velocity=(speed, 0.0), modes=8, damping=0.05)
    carriage = made.add(lf.Box(2e-3, 4e-3, mass=1e-3), "carriage", position=(-1e-3, 0.0), velocity=(speed, 0.0))
    for y in np.linspace(-0.5 * HEIGHT, 0.5 * HEIGHT, 5):  # the nodes of the root
        made.join(lf.Revolute(hook.at(0.0, y), carriage.at(1e-3, y)))
    place = made.ground.at(-1e-3, 0.0)
    made.join(lf.Prismatic(carriage.point("center"), place, axis=(1.0, 0.0), name="guide"))
    made.join(lf.DrivenDisplacement(carriage.point("center"), place, motion, (1.0, 0.0), name="drive"))
    made.contact(hook.surface("top"), made.ground.circle(RIB, RADIUS), friction=friction, name="rib")
    return made


def slowly(friction: float) -> lf.EquilibriumPath:
    """In and out, from rest to rest."""
    into = np.arange(0.0, STROKE + 0.5 * STEP, STEP)
    return lf.path(scene(friction, 0.0), "drive", np.concatenate([into, into[-2::-1]]))


def in_time(friction: float) -> lf.Result:
    """The way in, at ``SPEED``."""
    motion = lf.Table([0.0, STROKE / SPEED], [0.0, STROKE])
    return lf.simulate(scene(friction, motion, SPEED), STROKE / SPEED, lf.GeneralizedAlpha(1e-5), record=2e-5)


def beam_formula(friction: float) -> tuple[FloatArray, FloatArray]:
    """Path and force on the ramp, by the deflection of a slender arm and the angle of the undeformed ramp."""
    tangent = (ABOVE[3] - ABOVE[4]) / (ALONG[4] - ALONG[3])
    cosine = math.cos(math.atan(tangent))
    # centre of the rib from the line of the ramp is R at first touch: the arm then gives way by the rest
    first = RIB[0] - LENGTH + (RIB[1] - ABOVE[4] - RADIUS / cosine) / tangent
    path = np.linspace(first, first + 2.4e-3, 30)
    deflection = (path - first) * tangent
    stiffness = PLASTIC["youngs_modulus"] * THICKNESS * HEIGHT**3 / (4.0 * LENGTH**3)
    return path, stiffness * deflection * (friction + tangent) / (1.0 - friction * tangent)


def draw_stress(axes: Any, figure: Figure, result: lf.Result, t: float) -> None:
    """The von Mises stress at the nodes at a time, on the undeformed hook."""
    stress = result.stress("hook").at(t)
    x, y = stress.places.T
    triangles = Triangulation(x, y)
    middle = np.array([places[triangles.triangles].mean(axis=1) for places in (x, y)])
    triangles.set_mask(middle[1] > np.interp(middle[0], ALONG, ABOVE))
    millimetres = Triangulation(1e3 * x, 1e3 * y, triangles.triangles, triangles.mask)
    shown = axes.tricontourf(millimetres, 1e-6 * stress.von_mises, levels=20, cmap="viridis")
    figure.colorbar(shown, ax=axes, label="von Mises [MPa]", shrink=0.8, aspect=8)
    most = int(stress.von_mises.argmax())
    text = f"{1e-6 * stress.von_mises[most]:.0f} MPa"
    axes.annotate(text, 1e3 * stress.places[most], (2.0, -1.8), arrowprops={"arrowstyle": "->"}, va="center")
    axes.set(title=f"stress at the largest force, path {1e3 * SPEED * t:.2f} mm", aspect="equal", ylim=(-2.2, 2.4))
    axes.set(xlabel="along the arm [mm]", ylabel="[mm]")


def draw_places(axes: Any, result: lf.Result) -> None:
    """The outline of the hook before, at and behind the rib."""
    fine = np.column_stack([np.linspace(0.0, LENGTH, 81), np.interp(np.linspace(0.0, LENGTH, 81), ALONG, ABOVE)])
    for path, colour in ((0.5e-3, "C7"), (3.4e-3, "C0"), (7.5e-3, "C2")):
        k = int(np.abs(result.times * SPEED - path).argmin())
        upper = np.array([result.point("hook", (x, y))[k] for x, y in fine])
        lower = np.array([result.point("hook", (x, -0.5 * HEIGHT))[k] for x in fine[::-1, 0]])
        axes.plot(*(1e3 * np.concatenate([upper, lower, upper[:1]]).T), colour, label=f"path {1e3 * path:g} mm")
    turn = np.linspace(0.0, 2.0 * math.pi, 60)
    axes.fill(1e3 * (RIB[0] + RADIUS * np.cos(turn)), 1e3 * (RIB[1] + RADIUS * np.sin(turn)), color="0.6")
    axes.set(
        aspect="equal",
        xlabel="[mm]",
        ylabel="[mm]",
        ylim=(-2.5, 5.0),
        title="in time, 0.1 m/s: before, on and behind the rib",
    )
    axes.legend(loc="upper left", fontsize="small", ncols=3)


def draw_forces(axes: Any, friction: float, colour: str, result: lf.Result | None) -> float:
    """Force of the drive against its place, in and out; returns the largest of insertion [N]."""
    path = slowly(friction)
    assert path.force is not None
    turn = int(np.argmax(path.travel))
    label = f"at rest, friction {friction:g}"
    axes[0].plot(1e3 * path.travel[: turn + 1], path.force[: turn + 1], f"{colour}.-", label=label)
    axes[1].plot(1e3 * path.travel[turn:], -path.force[turn:], f"{colour}.-", label=label)
    axes[0].plot(*(np.array(beam_formula(friction)) * [[1e3], [1.0]]), f"{colour}:", label="beam formula, ramp")
    if result is not None:
        force = result.reaction("drive").force[:, 0]
        axes[0].plot(1e3 * SPEED * result.times, force, "0.6", zorder=0, label="in time")
    return float(path.force[: turn + 1].max())


def run(folder: Path = Path()) -> lf.Result:
    figure = Figure(figsize=(13, 7.5), layout="constrained")
    (into, out), (places, stress) = figure.subplots(2, 2, height_ratios=(2, 1))
    result = in_time(FRICTION[1])
    most = [draw_forces((into, out), mu, f"C{k}", result if k else None) for k, mu in enumerate(FRICTION)]
    assert most[0] < most[1]
    into.set(title="insertion", xlabel="path of the drive [mm]", ylabel="force that pushes [N]", ylim=(-4.0, 5.0))
    out.set(title="retention: pulled back", xlabel="path of the drive [mm]", ylabel="force that pulls [N]")
    out.invert_xaxis()
    for axes in (into, out):
        axes.grid(True, alpha=0.4)
        axes.legend(fontsize="small")
    draw_places(places, result)
    force = result.reaction("drive").force[:, 0]
    draw_stress(stress, figure, result, float(result.times[int(np.nanargmax(force))]))
    figure.savefig(folder / "snap_fit.png", dpi=100)
    return result


if __name__ == "__main__":
    print(run().summary())
