"""What a planar run loads: nothing of space, no solver or library that it does not call."""

from __future__ import annotations

import subprocess
import sys

RUN = """
import sys
import lcpflex as lf
scene = lf.Scene(gravity=(0.0, -9.81))
disc = scene.add(lf.Disc(radius=0.1, mass=1.0), position=(0.0, 0.12))
scene.contact(disc.surface(), scene.ground.half_plane((0.0, 0.0), (0.0, 1.0)), friction=0.3)
result = lf.simulate(scene, 0.1, lf.MoreauJean(step=1e-3))
assert result.force.any()
print(*sys.modules)
"""
# Numbers and formulas that the plane and space are told apart by.
SHARED = {
    "lcpflex.contact.spatial",
    "lcpflex.contact.spatial.kinds",
    "lcpflex.kinematics.spatial",
    "lcpflex.kinematics.spatial.frames",
    "lcpflex.model.spatial",
}
# Of more than 700 modules of lcpflex a run of one disc loads 341.
MOST = 370
UNUSED = (
    *("osqp", "clarabel", "qpsolvers", "skfem", "meshio", "matplotlib", "PIL", "pandas", "xarray", "h5py"),
    *("scipy.sparse", "scipy.optimize", "scipy.integrate", "scipy.interpolate", "scipy.spatial", "scipy.special"),
    *("lcpflex.gallery", "lcpflex.studies", "lcpflex.bodies.fem", "lcpflex.steppers.massless_boundary"),
    *("lcpflex.results.film", "lcpflex.results.plot", "lcpflex.solvers.benchmark", "lcpflex.steppers.smooth"),
)


def test_a_planar_run_loads_what_it_uses() -> None:
    ran = subprocess.run([sys.executable, "-c", RUN], capture_output=True, text=True, check=True)
    loaded = set(ran.stdout.split())
    ours = {name for name in loaded if name.partition(".")[0] == "lcpflex"}
    assert {name for name in ours if "spatial" in name.split(".")} <= SHARED
    assert not loaded & set(UNUSED)
    assert len(ours) <= MOST
