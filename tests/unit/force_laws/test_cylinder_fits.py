"""Power laws fitted to the laws of line contact, against the tables printed by Autiero et al. 2022."""

from __future__ import annotations

import csv
from pathlib import Path

import pytest

from lcpflex.errors import ModelError, ModelWarning
from lcpflex.force_laws.elastic.cylinder_pair import CylinderPair
from lcpflex.force_laws.elastic.explicit_line_laws import LankaraniNikraveshCylinder
from lcpflex.force_laws.elastic.line_contact import Esdu78035, Goldsmith, Johnson, Radzimovsky
from lcpflex.force_laws.elastic.materials import Material
from lcpflex.force_laws.elastic.power_fit import fit_power_law

MM = 1e-3
MATERIALS = {"steel": Material(207e9, 0.3), "aluminium": Material(70e9, 0.33)}
FIT_OF = {
    "radzimovsky": lambda pair: Radzimovsky(pair),
    "johnson": lambda pair: Johnson(pair),
    "esdu-78035-review": lambda pair: Esdu78035(pair, reading="review"),
}
COPIED = "esdu-78035-review", "aluminium"  # its exponents are those of the table of steel
SWAPPED = "johnson", "aluminium", 80.0  # its digits are: 1.083 for 1.108
EXPONENTS_OF_COPIED = {0.5: 1.200, 5.0: 1.137, 10.0: 1.125, 30.0: 1.110, 60.0: 1.102, 80.0: 1.099}

with (Path(__file__).parent / "cylinder_fit_tables.csv").open() as file:
    TABLES = list(csv.DictReader(line for line in file if not line.startswith("#")))


def fitted(law: str, material: str, clearance: float):
    """K [N/mm^n per mm], n and the greatest relative error from 1 um on, of a hole of 100 mm."""
    pair = [100.0 * MM, (100.0 - clearance) * MM]
    if law == "goldsmith":
        # Only one set of units gives the printed numbers: the square of the length in the logarithm is 1e8 mm^2, which
        # is m = 3 with a contact of 10 m under loads per mm.
        per_mm = 1e4
        law = Goldsmith(CylinderPair.internal(*pair, per_mm * MM, MATERIALS[material]), m=3)
    else:
        per_mm = 1.0
        law = FIT_OF[law](CylinderPair.internal(*pair, per_mm * MM, MATERIALS[material]))
    fit = fit_power_law(law, (0.0, 1000.0 * per_mm))
    assert fit.indentations[0] == 1e-6
    return fit.stiffness * MM**fit.exponent / per_mm, fit.exponent, fit.max_relative_error


@pytest.mark.parametrize("row", TABLES, ids=lambda row: f"{row['law']}-{row['material']}-{row['delta_R_mm']}")
def test_printed_tables(row):
    law, material, clearance = row["law"], row["material"], float(row["delta_R_mm"])
    K, n, error = fitted(law, material, clearance)
    assert pytest.approx(float(row["K_printed_N_per_mm_pow_n_plus_1"]), rel=5e-3) == K
    assert 100.0 * error == pytest.approx(float(row["max_error_percent_printed"]), abs=0.16)
    printed = float(row["n_printed"])
    if (law, material) == COPIED:
        assert abs(n - printed) > 8e-3
        assert n == pytest.approx(EXPONENTS_OF_COPIED[clearance], abs=1e-3)
    elif (law, material, clearance) == SWAPPED:
        assert abs(n - printed) > 0.02
        assert n == pytest.approx(1.108, abs=1e-3)
    else:
        assert n == pytest.approx(printed, abs=1e-3)


def test_the_copied_column_is_that_of_the_table_of_steel():
    column = {
        material: [row["n_printed"] for row in TABLES if (row["law"], row["material"]) == (COPIED[0], material)]
        for material in MATERIALS
    }
    assert len(column["steel"]) == 6
    assert column["steel"] == column["aluminium"]


STEEL = MATERIALS["steel"]
CONTACTS = {
    "inner": CylinderPair.external(52.0 * MM, 7.9 * MM, 1.0 * MM, STEEL),
    "outer": CylinderPair.internal(68.0 * MM, 7.9 * MM, 1.0 * MM, STEEL),
    "end cap": CylinderPair.internal(8.0 * MM, 7.9 * MM, 1.0 * MM, STEEL),
}
PREDICTED = {  # Radzimovsky, Johnson, the reading of the review: K [N/mm^n per mm], n; Lankarani and Nikravesh: K
    "inner": ((4.317e4, 1.091), (4.910e4, 1.100), (1.254e4, 1.092), 3.971e5),
    "outer": ((4.315e4, 1.091), (4.908e4, 1.100), (1.254e4, 1.092), 4.534e5),
    "end cap": ((1.846e5, 1.219), (3.147e5, 1.279), (4.786e4, 1.225), 3.812e6),
}


@pytest.mark.filterwarnings("ignore::lcpflex.errors.ModelWarning")  # of the ranges that are left, on purpose
@pytest.mark.parametrize("contact", CONTACTS)
def test_the_contacts_of_the_slotted_joint(contact):
    pair = CONTACTS[contact]
    laws = Radzimovsky(pair, lenient=True), Johnson(pair, lenient=True), Esdu78035(pair, "review", lenient=True)
    for law, (K, n) in zip(laws, PREDICTED[contact], strict=False):
        fit = fit_power_law(law, (0.0, 1000.0))
        assert fit.stiffness * MM**fit.exponent == pytest.approx(K, rel=6e-4)
        assert fit.exponent == pytest.approx(n, abs=6e-4)
    assert LankaraniNikraveshCylinder(pair).parameters[0] * MM**1.5 == pytest.approx(PREDICTED[contact][3], rel=2e-4)


def test_loads_of_the_tables_leave_the_range_of_the_end_cap():
    with pytest.raises(ModelError, match=r"force\[793\].*range of validity of Johnson"):
        fit_power_law(Johnson(CONTACTS["end cap"]), (0.0, 1000.0))
    with pytest.warns(ModelWarning, match="Johnson is valid up to"):
        fit_power_law(Johnson(CONTACTS["end cap"], lenient=True), (0.0, 1000.0))


def test_a_power_law_is_fitted_by_itself():
    from lcpflex.force_laws.elastic.power_law import PowerLaw

    fit = fit_power_law(PowerLaw(3e8, 1.3), (10.0, 500.0))
    assert fit.stiffness == pytest.approx(3e8, rel=1e-11)
    assert fit.exponent == pytest.approx(1.3, rel=1e-12)
    assert fit.max_relative_error < 1e-11
    assert fit.law == PowerLaw(fit.stiffness, fit.exponent)
    assert fit.indentations == pytest.approx(((10.49 / 3e8) ** (1 / 1.3), (500.0 / 3e8) ** (1 / 1.3)), rel=1e-9)


@pytest.mark.parametrize(
    ("arguments", "named"),
    [
        (("Johnson", (0.0, 1.0)), "law: 'Johnson'"),
        ((None, 5.0), "load_range: 5.0"),
        ((None, (-1.0, 5.0)), r"load_range\[0\]: -1.0"),
        ((None, (5.0, 5.0)), r"load_range\[1\]: 5.0"),
        ((None, (0.0, 1e-9)), "error_from: 1e-06"),
    ],
)
def test_no_fit(arguments, named):
    law, loads = arguments
    with pytest.raises(ModelError, match=named):
        fit_power_law(law or Johnson(CONTACTS["outer"]), loads)
    with pytest.raises(ModelError, match="points: 3"):
        fit_power_law(Johnson(CONTACTS["outer"]), (0.0, 100.0), points=3)
