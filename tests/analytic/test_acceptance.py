"""Every stepper on every reference case that it applies to, within the bounds of the table in ACCURACY.md."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

import lcpflex as lf
from lcpflex import gallery
from lcpflex.gallery.acceptance.check import ROUNDING, Absent, Check, Entry, Refused
from lcpflex.gallery.acceptance.table import CAMPAIGN, LABELS, checks, rows
from lcpflex.gallery.mechanisms.bars import courant_step
from lcpflex.runs.simulate import Stepper
from tests.rates import assert_rate

CHECKS = {check.label: check for check in checks()}
PAIRS = [(check, label) for check in CHECKS.values() for label in LABELS]
# Seconds each, of steppers that are here with other cases, and of cases that are here with other steppers.
LONG = {
    "sphere_on_beam-smooth",
    "meshed_sphere_on_rod-massless boundary",
    "meshed_sphere_on_rod-generalised-alpha",
    "spring_block-Moreau-Jean",
    "spring_block-generalised-alpha",
    "spring_block-smooth",
    "stick_slip-Moreau-Jean",
    "stick_slip-generalised-alpha",
    "stick_slip-smooth",
    "bar_with_foot-generalised-alpha",
    "slider_crank-event-driven",
    "slider_crank-generalised-alpha",
}
TABLE = (Path(lf.__file__).parent / "ACCURACY.md").read_text(encoding="utf-8").split(CAMPAIGN)[0]


def of(kind: type) -> list[object]:
    entries = {f"{check.label}-{label}": (check, label) for check, label in PAIRS}
    return [
        pytest.param(
            check,
            label,
            id=name,
            marks=[pytest.mark.slow] if name in LONG or getattr(check.entries[label], "slow", False) else [],
        )
        for name, (check, label) in entries.items()
        if isinstance(check.entries[label], kind)
    ]


@pytest.mark.parametrize(("check", "label"), of(Entry))
def test_stepper_reaches_the_reference(check: Check, label: str) -> None:
    entry = check.entries[label]
    assert isinstance(entry, Entry)
    result = check.run(entry.stepper)
    bounds = check.bounds(label)
    errors = [quantity.error(result) for quantity in check.quantities]
    exceeded = [
        f"{quantity.name}: {error:.3g}, bound {bound:g}"
        for quantity, error, bound in zip(check.quantities, errors, bounds, strict=True)
        if not error <= bound
    ]
    assert not exceeded


@pytest.mark.parametrize(("check", "label"), of(Refused))
def test_stepper_refuses(check: Check, label: str) -> None:
    entry = check.entries[label]
    assert isinstance(entry, Refused)
    with pytest.raises((lf.ModelError, lf.StepError), match=entry.message):
        check.run(entry.stepper)


@pytest.mark.parametrize(
    ("check", "label"), [(c, k) for c, k in PAIRS if isinstance(e := c.entries[k], Absent) and e.stepper is not None]
)
def test_stepper_says_what_it_leaves_out(check: Check, label: str) -> None:
    entry = check.entries[label]
    assert isinstance(entry, Absent)
    assert entry.stepper is not None
    scene = check.case.build()
    result = lf.simulate(scene, 1e-4, entry.stepper)
    assert any(entry.warning in warning for warning in result.warnings)


def test_table_has_the_rows_of_the_checks() -> None:
    """Same lines in the same order; the same cells are empty; errors in it are within the bounds, and near them."""
    lines = [line for line in TABLE.splitlines() if line.startswith("| ")][1:]
    expected = [(check, row) for check in CHECKS.values() for row in rows(check, measure=False)]
    assert len(lines) == len(expected)
    position: dict[str, int] = {}
    for line, (check, row) in zip(lines, expected, strict=True):
        cells = [cell.strip() for cell in line.strip("|").split("|")]
        assert cells[:3] == [row.check, row.quantity, row.reference]
        if row.quantity == "with":
            assert cells[3:] == list(row.cells)
        if row.quantity in ("with", "time"):
            continue
        k = position.get(row.check, 0)
        position[row.check] = k + 1
        for label, cell in zip(LABELS, cells[3:], strict=True):
            if not isinstance(check.entries[label], Entry):
                assert cell == "-"
                continue
            error, bound = float(cell), check.bounds(label)[k]
            assert 0.95 * error <= bound  # two digits are printed
            assert bound <= max(3.2 * max(error, ROUNDING), 1.1 * check.floor(check.quantities[k]))


def test_every_method_that_does_not_apply_says_why() -> None:
    for check, label in PAIRS:
        entry = check.entries[label]
        assert isinstance(entry, Entry) or entry.why
        assert all(math.isfinite(quantity.reference) for quantity in check.quantities)


def energy_ratio(stepper: Stepper, elements: int = 100) -> float:
    """Energy left of the pre-stressed bar after 20 periods."""
    result = lf.simulate(gallery.prestressed_bar(elements=elements), 60.0, stepper, record=0.1)
    assert result.energies.stored.max() <= 1.01 * result.energies.stored[0]
    return float(result.energies.stored[-1] / result.energies.stored[0])


def test_massless_boundary_keeps_the_energy_for_twenty_periods() -> None:
    assert energy_ratio(lf.MasslessBoundary()) == pytest.approx(1.0, abs=0.001)


def test_moreau_jean_loses_the_energy_of_the_node_that_strikes() -> None:
    """Its mass goes down with the mesh, and so does the loss: below 1 % in 20 periods at 200 elements."""
    meshes = np.array([50, 100, 200])
    lost = [1.0 - energy_ratio(lf.MoreauJean(step=courant_step(1.0 / n, 1.0)), n) for n in meshes]
    assert lost[-1] < 0.01
    assert_rate(1.0 / meshes, lost, 1.2, within=0.3)


def test_generalized_alpha_loses_more_the_smaller_rho_inf_is() -> None:
    step = courant_step(0.01, 1.0)
    kept = [energy_ratio(lf.GeneralizedAlpha(step=step, rho_inf=rho)) for rho in (1.0, 0.8, 0.4, 0.0)]
    assert kept == sorted(kept, reverse=True)
    assert kept[0] == pytest.approx(energy_ratio(lf.MoreauJean(step=step)), abs=0.01)  # no numerical damping
