"""What the commands load when they are carried out: ``lcpflex --help`` starts without numba, scipy and matplotlib."""

from __future__ import annotations

from typing import TYPE_CHECKING

from lcpflex.basics.lazy import attach

if TYPE_CHECKING:
    from lcpflex.force_laws.penalty import Penalty
    from lcpflex.gallery import Case, scenes, warmup_cases
    from lcpflex.jit.background import compile_all_listed
    from lcpflex.jit.cache import lost
    from lcpflex.jit.keys import LEVELS
    from lcpflex.jit.late import compile_all
    from lcpflex.runs.named_steppers import kind_named
    from lcpflex.runs.simulate import simulate
    from lcpflex.solvers.arguments import check_repeats
    from lcpflex.solvers.benchmark.comparison import all_solvers
    from lcpflex.solvers.benchmark.fclib import load_fclib
    from lcpflex.solvers.benchmark.files import Recorded, load_problems, load_text_lcp
    from lcpflex.solvers.benchmark.replays import replay
    from lcpflex.solvers.benchmark.siconos_files import load_siconos
    from lcpflex.solvers.clock import check_time_limit
    from lcpflex.solvers.limits import check_tolerance
    from lcpflex.solvers.user_solver import as_solver
    from lcpflex.steppers.event_driven.stepper import EventDriven
    from lcpflex.steppers.generalized_alpha.stepper import GeneralizedAlpha
    from lcpflex.steppers.massless_boundary.stepper import MasslessBoundary
    from lcpflex.steppers.moreau_jean.stepper import MoreauJean
    from lcpflex.steppers.smooth.stepper import ExplicitRungeKutta, Smooth, Verlet
    from lcpflex.studies.convergence.methods import standard_methods
    from lcpflex.studies.convergence.work_precision import work_precision
    from lcpflex.studies.model_order.right_size import right_size
    from lcpflex.studies.model_order.scenes import known_outputs
    from lcpflex.studies.stability_maps.acceleration_level import acceleration_level
    from lcpflex.studies.stability_maps.study import stability

__getattr__, __dir__ = attach(__name__)
