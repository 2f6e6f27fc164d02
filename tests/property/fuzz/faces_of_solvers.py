"""Contact problems and their solvers."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np

from lcpflex import solvers
from tests.property.fuzz.face import Face, boxed, contact, lcp, mixed

__all__ = ["solver_faces"]


LOADERS = (
    "load_problems",
    "load_text_lcp",
    "load_fclib",
    "load_siconos",
    "load_siconos_contacts",
    "load_siconos_lcp",
    "load_siconos_mlcp",
)


def _own(M: Any, q: Any) -> Any:
    return np.maximum(-q, 0.0)


def _owned() -> solvers.UserSolver:
    return solvers.UserSolver(_own)


def _stuck(problem: Any) -> Any:
    return [1.0, 0.0, -0.1]


def _in_space() -> solvers.SpatialContactProblem:
    return solvers.SpatialContactProblem(np.eye(3), [-1.0, 0.0, 0.1], [0.3])


def _timed() -> solvers.TimeLimit:
    return solvers.TimeLimit(solvers.Lemke(), 1.0)


@cache
def _replayed() -> solvers.Replay:
    return solvers.replay([lcp()], {"Lemke": solvers.Lemke()}, repeats=1)


def solver_faces() -> list[Face]:
    kinds = {"": lcp, " of contact": contact, " boxed": boxed, " mixed": mixed}
    out: list[Face] = [
        Face("Lcp", solvers.Lcp, lambda: {"M": np.eye(2), "q": [-1.0, 1.0]}),
        Face(
            "BoxedLcp", solvers.BoxedLcp, lambda: {"M": np.eye(2), "q": [-1.0, 1.0], "lower": 0.0, "upper": [1.0, 2.0]}
        ),
        Face("MixedLcp", solvers.MixedLcp, lambda: {"M": np.eye(2), "q": [-1.0, 1.0], "free": [0]}),
        Face(
            "ContactProblem",
            solvers.ContactProblem,
            lambda: {"delassus": np.eye(3), "free": [-1.0, -1.0, 0.1], "friction": [0.0, 0.3]},
        ),
        Face(
            "SpatialContactProblem",
            solvers.SpatialContactProblem,
            lambda: {"delassus": np.eye(3), "free": [-1.0, 0.0, 0.1], "friction": [0.3]},
        ),
        *(
            Face(
                f"SpatialContactProblem.{name}",
                getattr(solvers.SpatialContactProblem, name),
                lambda given=given: {given: [1.0, 0.0, 0.0]},
                _in_space,
            )
            for name, given in (
                ("residual", "z"),
                ("residuals", "z"),
                ("by_terms", "z"),
                ("slack", "z"),
                ("forces", "z"),
                ("velocity", "forces"),
            )
        ),
        Face(
            "SpatialContactProblem.solve_by",
            solvers.SpatialContactProblem.solve_by,
            lambda: {"solver": solvers.UserSolver(_stuck, takes="problem")},
            _in_space,
        ),
        Face("accept", solvers.accept, lambda: {"problem": lcp(), "z": [0.0, 0.0], "tolerance": 1e-10}),
        Face("solve_lcp", solvers.solve_lcp, lambda: {"M": np.eye(2), "q": [-1.0, 1.0]}),
        Face(
            "cross_check",
            solvers.cross_check,
            lambda: {"problem": lcp(), "solvers": {"Lemke": solvers.Lemke()}, "repeats": 1},
        ),
        Face(
            "contact_solutions",
            solvers.contact_solutions,
            lambda: {"delassus": np.eye(3), "free": [-1.0, 0.0, 0.1], "friction": 0.3},
        ),
        Face("all_solvers", solvers.all_solvers, dict),
        Face("save_problems", solvers.save_problems, lambda: {"path": "problems.npz", "problems": [lcp()]}),
        *(Face(name, getattr(solvers, name), lambda: {"path": "unused"}) for name in LOADERS),
        Face("save_fclib", solvers.save_fclib, lambda: {"path": "problem.hdf5", "problem": contact()}),
        Face("Replay.plot", solvers.Replay.plot, dict, _replayed),
        Face("UserSolver", solvers.UserSolver, lambda: {"function": _own}),
        Face("UserSolver.solve", solvers.UserSolver.solve, lambda: {"problem": lcp()}, _owned),
        Face("UserSolver.refuses", solvers.UserSolver.refuses, lambda: {"problem": lcp()}, _owned),
        Face("TimeLimit", solvers.TimeLimit, lambda: {"solver": solvers.Lemke(), "seconds": 1.0}),
        Face("TimeLimit.solve", solvers.TimeLimit.solve, lambda: {"problem": lcp()}, _timed),
        Face("TimeLimit.refuses", solvers.TimeLimit.refuses, lambda: {"problem": lcp()}, _timed),
        Face(
            "replay",
            solvers.replay,
            lambda: {"problems": [lcp()], "solvers": {"Lemke": solvers.Lemke()}, "repeats": 1},
        ),
    ]
    for name in (
        "AlartCurnier",
        "Auto",
        "BlockGaussSeidel",
        "ConicFixedPoint",
        "ConvexFriction",
        "Enumeration",
        "FacetedCone",
        "GaussSeidel",
        "Lemke",
        "MinMapNewton",
        "PrincipalPivoting",
        "QuadraticProgram",
    ):
        kind = getattr(solvers, name)
        spatial = dict.fromkeys(("AlartCurnier", "ConicFixedPoint", "FacetedCone"), _in_space)
        problem = {"ConvexFriction": contact, **spatial}.get(name, lcp)
        out += [
            Face(name, kind, dict),
            Face(f"{name}.solve", kind.solve, lambda problem=problem: {"problem": problem()}, kind),
            Face(f"{name}.refuses", kind.refuses, lambda problem=problem: {"problem": problem()}, kind),
        ]
    for label, make in kinds.items():
        kind, plain = type(make()), label in ("", " of contact")
        points: dict[str, dict[str, Any]] = {
            "slack": {"z": np.zeros(make().size)},
            "residual": {"z": np.zeros(make().size)},
            **({name: {"z": np.zeros(make().size)} for name in ("residuals", "by_terms")} if plain else {}),
        }
        points["solve_by"] = {"solver": solvers.Lemke()}
        if label == " of contact":
            points |= {
                "forces": {"z": np.zeros(4)},
                "velocity": {"forces": np.zeros(3)},
                "unknowns": {"lambda_normal": np.zeros(2), "lambda_tangent": np.zeros(1)},
            }
        elif label:
            points["recover"] = {"x": np.zeros(make().lcp().size)}
        out += [
            Face(f"{kind.__name__}.{name}", getattr(kind, name), lambda given=given: dict(given), make)
            for name, given in points.items()
        ]
    return out
