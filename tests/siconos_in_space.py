"""The contact problems in space that Siconos ships with its own tests: all by name, and what a solver makes of them.

    python -m tests.siconos_in_space FOLDER         # the table of lcpflex/ACCURACY.md

FOLDER is `numerics/src/FrictionContact/test/data` of a copy of <https://github.com/siconos/siconos>. "local" problems
are u = W r + q; "global" ones hold the bodies, which the reader eliminates. Left out: problems in the plane, with
rolling friction, and FCLIB's, which Siconos' tests name but do not hold.
"""

from __future__ import annotations

import argparse
from dataclasses import dataclass
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np

from lcpflex.solvers import Auto, SpatialContactProblem, load_fclib, load_siconos_contacts

HARD = "RockPile_tob1.dat"  # 743 of 1389 rows independent, friction 1, W unsymmetric by 0.25 %
ELSEWHERE = {"LMGC_GlobalFrictionContactProblem00046.hdf5": "../../../../python/tests/data"}
GLOBAL = {
    "GFC3D_Example0.dat": 1,
    "GFC3D_Example00.dat": 1,
    "GFC3D_Example00_badly_scaled.dat": 1,
    "GFC3D_Example1.dat": 1,
    "GFC3D_OneContact.dat": 1,
    "GFC3D_TwoRods1.dat": 3,
    "LMGC_GlobalFrictionContactProblem00046.hdf5": 9,
    "Spheres-i099-356-679.hdf5": 356,
}
LOCAL = {
    "Box_Stacks-i0122-82-5.hdf5": 82,
    "BoxesStack1-i100000-32.hdf5.dat": 52,
    "Capsules-i100-1090.dat": 276,
    "Capsules-i100-889.dat": 276,
    "Capsules-i101-404.dat": 225,
    "Capsules-i103-990.dat": 275,
    "Capsules-i122-1617.dat": 296,
    "Capsules-i125-1213.hdf5": 286,
    "Confeti-ex03-Fc3D-SBM.dat": 54,
    "Confeti-ex13-4contact-Fc3D-SBM.dat": 4,
    "Confeti-ex13-Fc3D-SBM.dat": 107,
    "FC3D_Example1.dat": 3,
    "FC3D_Example1_SBM.dat": 3,
    "FrictionContact3D_1c.dat": 1,
    "FrictionContact3D_RR_1c.dat": 1,
    "GFC3D_Example0_SBM.dat": 1,
    "GFC3D_TwoRods1-condensed.dat": 3,
    "KaplasTower-i1061-4.hdf5.dat": 570,
    "LMGC_100_PR_PerioBox-i00361-60-03000.hdf5": 60,
    "NESpheres_10_1.dat": 9,
    "NESpheres_30_1.dat": 44,
    "OneObject-i100000-316.hdf5.dat": 25,
    "OneObject-i100000-499.hdf5.dat": 24,
    "OneObject-i1028-138.hdf5.dat": 23,
    HARD: 463,
    "Rover1039.dat": 4,
    "Rover1040.dat": 5,
    "Rover1041.dat": 5,
    "Rover11035.dat": 1,
    "Rover11211.dat": 1,
    "Rover3865.dat": 5,
    "Rover4144.dat": 4,
    "Rover4396.dat": 2,
    "Rover4493.dat": 4,
    "Rover4516.dat": 4,
    "Rover4609.dat": 5,
    "Rover4613.dat": 5,
    "Rover4622.dat": 4,
    "Rover9770.dat": 5,
    "spheres-in-a-box-98-i10000-256-10.hdf5": 256,
}
CONTACTS = dict(sorted((LOCAL | GLOBAL).items()))


@dataclass(frozen=True)
class Answer:
    """What a solver made of a problem; ``theirs`` is the residual of Siconos."""

    name: str
    contacts: int
    status: str
    residual: float
    strict: float
    theirs: float
    seconds: float

    def line(self) -> str:
        """In Markdown."""
        form = "global" if self.name in GLOBAL else "local"
        sizes = (f"{x:.0e}" if x >= 1e-16 else "0" for x in (self.residual, self.strict, self.theirs))
        cells = (self.name, form, str(self.contacts), self.status, *sizes, f"{1e3 * self.seconds:.2g}")
        return f"| {' | '.join(cells)} |"


def load(folder: Path, name: str) -> SpatialContactProblem:
    """The problem of that name."""
    path = folder / ELSEWHERE.get(name, ".") / name
    problem = load_fclib(path) if path.suffix == ".hdf5" else load_siconos_contacts(path)
    assert isinstance(problem, SpatialContactProblem)
    assert len(problem.friction) == CONTACTS[name]
    return problem


def siconos_residual(problem: SpatialContactProblem, forces: Any) -> float:
    """|r - P_K(r - rho (u + mu |u_T| n))| / |q|, rho = 1: the natural map of Siconos, in the units of the file."""
    u, r, mu = problem.velocity(forces).reshape(-1, 3), forces.reshape(-1, 3), problem.friction
    x = r - u
    x[:, 0] -= mu * np.hypot(u[:, 1], u[:, 2])
    slip = np.hypot(x[:, 1], x[:, 2])
    normal = np.where(mu * slip <= -x[:, 0], 0.0, (x[:, 0] + mu * slip) / (1.0 + mu * mu))
    shrink = mu * normal / np.maximum(slip, 1e-300)
    edge = np.column_stack([normal, x[:, 1] * shrink, x[:, 2] * shrink])
    nearest = np.where((slip <= mu * x[:, 0])[:, None], x, edge)
    return float(np.linalg.norm(r - nearest) / np.linalg.norm(problem.free))


def answered(problem: SpatialContactProblem, name: str, solver: Any) -> Answer:
    """The solver on the problem, and its time."""
    began = perf_counter()
    found = solver.solve(problem)
    seconds = perf_counter() - began
    theirs = siconos_residual(problem, found.z)
    return Answer(name, len(problem.friction), found.status.name, found.residual, found.strict, theirs, seconds)


def main() -> None:
    """The command."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    folder = parser.parse_args().folder
    answered(load(folder, "Rover4396.dat"), "", Auto())  # compiles
    print(
        "| problem | form | contacts | status | residual | strict | Siconos | ms |\n|---|---|---|---|---|---|---|---|"
    )
    total = 0.0
    for name in CONTACTS:
        one = answered(load(folder, name), name, Auto())
        total += one.seconds if name != HARD else 0.0
        print(one.line(), flush=True)
    print(f"\n{len(CONTACTS) - 1} problems without {HARD}: {total:.1f} s together")


if __name__ == "__main__":
    main()
