"""What the review of Autiero et al. says of its tables, by the example that computes them."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pytest

import lcpflex as lf
from tests.examples import Example, example
from tests.scenes import disc_on_floor

TABLES = Example("slotted_joint_tables")
SHORT = {
    "radzimovsky": "Radzimovsky",
    "johnson": "Johnson",
    "goldsmith": "Goldsmith",
    "esdu-78035-review": "ESDU 78035",
}


def test_printed_numbers_of_the_example() -> None:
    """They are those of the file that the laws are tested against."""
    with (Path(__file__).parent / "cylinder_fit_tables.csv").open() as file:
        rows = list(csv.DictReader(line for line in file if not line.startswith("#")))
    assert len(rows) == 6 * len(TABLES.PRINTED)
    for row in rows:
        column = TABLES.CLEARANCES.index(float(row["delta_R_mm"]))
        printed = [values[column] for values in TABLES.PRINTED[SHORT[row["law"]], row["material"]]]
        expected = [float(row[key]) for key in row if "printed" in key]
        assert [1e3 * printed[0], *printed[1:]] == pytest.approx(expected, rel=1e-12)


def test_stiffness_exponent_and_error_fall_with_the_clearance() -> None:
    """As printed and as computed; the softer material has less stiffness, a higher exponent and more error."""
    computed = TABLES.tables()
    for (law, material), printed in TABLES.PRINTED.items():
        values = computed[law, material]
        assert np.all(np.diff(values, axis=1) < 0.0)
        assert np.all(np.diff(printed, axis=1) < 0.0)
        assert values[0] == pytest.approx(printed[0], rel=5e-3)
        if material == "aluminium":
            steel = computed[law, "steel"]
            assert np.all(values[0] < steel[0])
            assert np.all(values[1:] > steel[1:])


def test_misprints() -> None:
    """Table 8 repeats the exponents of table 7; one of table 4 has two digits swapped."""
    assert TABLES.PRINTED["ESDU 78035", "aluminium"][1] == TABLES.PRINTED["ESDU 78035", "steel"][1]
    apart = {}
    for (law, material), printed in TABLES.PRINTED.items():
        pairs = [
            lf.laws.CylinderPair.internal(0.1, (100.0 - c) * 1e-3, 1e-3, TABLES.MATERIALS[material])
            for c in TABLES.CLEARANCES[::5]
        ]
        exponents = np.array([TABLES.fitted(law, pair)[1] for pair in pairs])
        apart[law, material] = np.abs(exponents - printed[1][::5])
    wrong = {key: values.max() for key, values in apart.items() if values.max() > 1e-3}
    assert wrong == {
        ("Johnson", "aluminium"): pytest.approx(0.0254, abs=1e-4),
        ("ESDU 78035", "aluminium"): pytest.approx(0.0352, abs=1e-4),
    }


def test_table_of_the_yoke() -> None:
    """Both tracks have nearly one clearance, and so one law; the ends are stiffer, and n is higher, by every fit."""
    for law in ("Radzimovsky", "Johnson", "Goldsmith", "ESDU 78035"):
        (inner, n_inner), (outer, n_outer), (end, n_end) = TABLES.joint(law).values()
        assert inner == pytest.approx(outer, rel=0.02)
        assert n_inner == pytest.approx(n_outer, abs=1e-3)
        assert end > 1.2 * outer
        assert n_end > n_outer
    assert {n for _, n in TABLES.joint("Lankarani").values()} == {1.5}


@pytest.mark.slow
def test_impacts_by_the_table_and_by_the_law() -> None:
    """Peak force within 0.2 %; the law itself matters by a factor of two."""
    yoke = vars(example("scotch_yoke"))
    peaks = {}
    for law in TABLES.COLOURS:
        _, time, force = TABLES.impact(yoke, lambda pair, law=law: TABLES.by_table(law, pair))
        peaks[law] = force[time < 0.6].max()
        if law in ("Radzimovsky", "Johnson", "ESDU 78035"):
            _, time, force = TABLES.impact(yoke, lambda pair, law=law: TABLES.implicit(law, pair))
            assert peaks[law] == pytest.approx(force[time < 0.6].max(), rel=2e-3)
    assert sorted(peaks, key=peaks.get) == ["Lankarani", "ESDU 78035", "Goldsmith", "Radzimovsky", "Johnson"]
    assert peaks["Johnson"] > 2.0 * peaks["Lankarani"]


def test_defects_of_spring_and_dashpot() -> None:
    """Its introduction: the force jumps at the touch, c v_0, and would pull before the indentation is zero.

    Here it does not pull: it is zero from there on, while surfaces are still indented; c is the same throughout.
    """
    stiffness, speed = 1e6, 0.5
    damping = lf.laws.KelvinVoigt(0.5, mass=1.0)
    law = lf.ContactLaw(lf.laws.PowerLaw(stiffness, 1.0), damping)
    scene = disc_on_floor(0.1 + 1e-4, (0.0, -speed), gravity=0.0)
    result = lf.simulate(scene, 4e-3, lf.Smooth(law), record=2e-6, progress=False)
    depth = -np.nan_to_num(result.contact("floor").gap, nan=-1.0)
    force, rate = result.contact("floor").force[:, 0], -result.u[:, 1]
    c = 2.0 * damping.parameters[0] * np.sqrt(stiffness)
    pushed = force > 0.0
    first = int(np.argmax(pushed))
    assert force[first] == pytest.approx(c * speed, rel=0.02)
    assert (force - stiffness * depth)[pushed] == pytest.approx(c * rate[pushed], rel=1e-9, abs=1e-9)
    still = (depth > 0.0) & ~pushed
    assert still.sum() > 50
    assert np.all((stiffness * depth + c * rate)[still] <= 1e-9)
