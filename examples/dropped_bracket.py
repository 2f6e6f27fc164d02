"""A bracket from a Gmsh file is dropped on a floor: where is its stress, and which of its peaks is one?

``meshes/bracket.msh`` (made of ``bracket.geo`` by Gmsh) holds an angle bracket of 5 mm steel with a rounded inner
corner and a bolt hole: 1263 tetrahedra of ten nodes, and groups of faces named "foot", "fillet" and "bore". It falls
0.2 m, tilted by 5 degrees, so that the tip of its foot strikes first and the heel slaps down 2.3 ms later. All nodes of
the foot may touch the floor, without friction. The body keeps 24 free modes and a static mode for a normal force on
each of those nodes.

The floor gives nothing but impulse: at each instant  m v_z + m g t - m v_z(0)  is what the contact gave, to rounding.

The largest stress of all is at the edges that strike. A sharp edge on a rigid plane has no stress that could be
computed: the finer the mesh is, the larger it becomes. In the fillet, where the upright leg bends as its foot stops, it
has a limit: some 0.2 GPa here, 10 % more or less with half the step or half the modes, as a slap of 40 us excites many.
"""

from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from mpl_toolkits.mplot3d.art3d import Poly3DCollection
from scipy.spatial.transform import Rotation

import lcpflex as lf
from lcpflex.bodies import SurfaceShape

STEEL = {"density": 7850.0, "youngs_modulus": 2.1e11, "poissons_ratio": 0.3}
FILE = Path(__file__).parent / "meshes" / "bracket.msh"
TIP = np.array([0.06, 0.015, 0.0])  # middle of the edge that strikes first, in the file [m]
HEIGHT, TILT, GRAVITY, END = 0.2, 5.0, 9.81, 4e-3  # of the fall [m], [degrees], [m/s^2], [s]


def bracket() -> lf.Solid:
    """The mesh of the file, in which lengths are millimetres."""
    return lf.Solid(str(FILE), length_unit="mm", **STEEL)


def scene_of(body: lf.SpatialBody) -> lf.SpatialScene:
    """The bracket an instant before it touches the floor."""
    scene = lf.SpatialScene(gravity=(0.0, 0.0, -GRAVITY))
    placed = scene.add(
        body, name="bracket", point=tuple(TIP - body.origin), position=(0.0, 0.0, 1e-6),
        velocity=(0.0, 0.0, -np.sqrt(2.0 * GRAVITY * HEIGHT)),
        orientation=Rotation.from_euler("y", TILT, degrees=True),
    )  # fmt: skip
    floor = scene.ground.plane((0.0, 0.0, 0.0), (0.0, 0.0, 1.0))
    scene.contact(placed.face("foot"), floor, points="nodes", name="floor")
    return scene


def draw_stress(axes: Any, result: lf.Result, body: lf.SpatialBody, record: int, largest: float) -> Any:
    """The deformed surface in colours of von Mises' stress; what is above ``largest`` [Pa] has the colour of that."""
    shape = body.shape
    assert isinstance(shape, SurfaceShape)
    stress = 1e-6 * result.stress("bracket").of(record).von_mises
    places = result.q[record, :3] + result.orientation("bracket")[record].apply(shape.deformed(result.q[record, 7:]))
    corners = places[shape.triangles]
    colours = Poly3DCollection(1e3 * corners, edgecolors=(0.0, 0.0, 0.0, 0.15), linewidths=0.2, cmap="turbo")
    colours.set_array(stress[shape.triangles].mean(axis=1))
    colours.set_clim(0.0, 1e-6 * largest)
    axes.add_collection3d(colours)
    low, high = 1e3 * places.min(axis=0), 1e3 * places.max(axis=0)
    axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), zlim=(low[2], high[2]))
    axes.set_box_aspect(high - low)
    axes.set(xlabel="x [mm]", ylabel="y [mm]", zlabel="z [mm]")
    axes.view_init(22.0, -50.0)
    return colours


def run(folder: Path = Path()) -> lf.Result:
    solid = bracket()
    body = solid.reduce(modes=24, contact="foot", rows="normal", damping=0.005)
    result = lf.simulate(scene_of(body), END, lf.MoreauJean(step=1e-6), record=2e-5)
    contact = result.contact("floor")
    fillet = solid.finite_elements().sets["fillet"]
    history = result.stress("bracket").all().von_mises
    in_fillet = history[:, fillet].max(axis=1)
    k, node = np.unravel_index(history.argmax(), history.shape)
    place = 1e3 * (result.stress("bracket").places[node] + body.origin)
    worst = int(in_fillet.argmax())
    momentum = result.momentum().linear[:, 2]
    book = momentum - momentum[0] - contact.impulse[:, 0] + body.mass * GRAVITY * result.times
    print(f"{len(solid.finite_elements().dofs) // 3} nodes; {body.modes} modes, of which {body.residual_modes} static")
    print(f"largest von Mises stress: {1e-6 * history[k, node]:.0f} MPa at {place.round(1)} mm, where an edge strikes")
    print(f"in the fillet: {1e-6 * in_fillet[worst]:.0f} MPa at {1e3 * result.times[worst]:.2f} ms")
    print(f"book of momentum: {np.abs(book).max():.1e} N s of {contact.impulse[-1, 0]:.3f} N s are left over")
    print(f"{result.wall_time:.2g} s", *result.warnings, sep="\n  ")
    assert np.abs(book).max() < 1e-12  # rounding, of some thousand steps
    assert 1.6e8 < in_fillet[worst] < 2.6e8  # 207 to 233 MPa with 12 and 24 modes, steps of 1 and .5 us

    figure = Figure(figsize=(13, 7), layout="constrained")
    grid = figure.add_gridspec(2, 2, width_ratios=(1.5, 1.0))
    axes = figure.add_subplot(grid[:, 0], projection="3d")
    colours = draw_stress(axes, result, body, worst, in_fillet[worst])
    axes.set_title(f"{1e3 * result.times[worst]:.2f} ms: the heel has struck, the upright leg bends")
    figure.colorbar(colours, ax=axes, shrink=0.6, label="von Mises stress [MPa]", extend="max")
    force, stress = figure.add_subplot(grid[0, 1]), figure.add_subplot(grid[1, 1])
    force.plot(1e3 * contact.times, contact.impulse[:, 0], label="impulse of the floor")
    force.plot(1e3 * contact.times, momentum - momentum[0] + body.mass * GRAVITY * result.times, "k:",
               label="m v + m g t - m v(0)")  # fmt: skip
    force.set(ylabel="[N s]", xlabel="time [ms]")
    force.legend()
    stress.plot(1e3 * result.times, 1e-6 * history.max(axis=1), linewidth=0.8, label="anywhere: at edges that strike")
    stress.plot(1e3 * result.times, 1e-6 * in_fillet, label="in the fillet")
    stress.set(ylabel="largest von Mises stress [MPa]", xlabel="time [ms]", ylim=(0.0, 1.4e-6 * history.max()))
    stress.legend()
    figure.savefig(folder / "dropped_bracket.png", dpi=110)
    return result


if __name__ == "__main__":
    print(run().summary())
