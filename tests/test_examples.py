"""Every example runs, meets its reference, and leaves its picture."""

from __future__ import annotations

from pathlib import Path

import pytest

from lcpflex import Result
from tests.examples import EXAMPLES, example

STUDIES = (
    "ball_on_rod",
    "ball_on_solid_block",
    "chain_of_rings",
    "claw",
    "claw_in_step",
    "cross_check_solvers",
    "dropped_bracket",
    "falling_chain",
    "flexible_pendulum_micro_collisions",
    "four_strikers",
    "free_fall_and_strike",
    "gripper",
    "hopper_and_silo",
    "many_laws",
    "own_method",
    "pendulum_strikes_rod",
    "penalty_against_complementarity",
    "residual_modes",
    "right_size",
    "scotch_yoke",
    "settling_heap",
    "slider_crank_with_flexible_stop",
    "slotted_joint_tables",
    "snap_fit",
    "soft_gripper",
    "solid_pendulum_strikes_rod",
    "solid_slider_crank",
    "spatial_pendulum_micro_collisions",
    "strip_pile",
    "two_spheres",
    "velocity_behind_contact",
    "where_methods_fail",
    "work_precision",
)  # many runs each


def test_there_are_examples() -> None:
    assert len(EXAMPLES) >= 10


@pytest.mark.parametrize(
    "path",
    [pytest.param(path, id=path.stem, marks=[pytest.mark.slow] * (path.stem in STUDIES)) for path in EXAMPLES],
)
def test_example(path: Path, tmp_path: Path) -> None:
    module = example(path.stem)
    assert module.__doc__
    result = module.run(tmp_path)
    assert isinstance(result, Result)
    assert result.complete
    assert (tmp_path / f"{path.stem}.png").stat().st_size > 10_000
