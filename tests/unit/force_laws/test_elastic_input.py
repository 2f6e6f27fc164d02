"""What elastic laws refuse, and what they say."""

from __future__ import annotations

import math
import warnings

import numpy as np
import pytest

from lcpflex.errors import ModelError, ModelWarning
from lcpflex.force_laws.elastic.cylinder_pair import CylinderPair
from lcpflex.force_laws.elastic.explicit_line_laws import LankaraniNikraveshCylinder, Liu, Pereira, Persson
from lcpflex.force_laws.elastic.hertz import Hertz
from lcpflex.force_laws.elastic.line_contact import DubowskyFreudenstein, Esdu78035, Goldsmith, Johnson, Radzimovsky
from lcpflex.force_laws.elastic.materials import Material
from lcpflex.force_laws.elastic.power_fit import fit_power_law
from lcpflex.force_laws.elastic.power_law import PowerLaw

STEEL = Material(207e9, 0.3)
ALUMINIUM = Material(70e9, 0.33)
RUBBER = Material(2e6, 0.49)
PIN = CylinderPair.internal(0.008, 0.0079, 0.01, STEEL)
SIDE = CylinderPair.external(0.052, 0.0079, 0.01, STEEL)
LINES = [Johnson, Radzimovsky, Goldsmith, DubowskyFreudenstein, Esdu78035, LankaraniNikraveshCylinder]
LINES += [Pereira, Liu, Persson]
LAWS = [PowerLaw(1e9), Hertz.spheres(0.01, 0.02, STEEL), *(law(PIN) for law in LINES)]
EVERY = pytest.mark.parametrize("law", LAWS, ids=lambda law: type(law).__name__)


@EVERY
@pytest.mark.parametrize("bad", [-1e-9, math.nan, math.inf, -math.inf])
def test_indentations_and_forces_that_are_none(law, bad):
    for method, name in ((law.force, "delta"), (law.stiffness, "delta"), (law.energy, "delta")):
        with pytest.raises(ModelError, match=rf"^{name}: {bad!r} was given, expected a finite number >= 0"):
            method(bad)
        values = np.full((2, 3), 1e-6)
        values[1, 2] = bad
        with pytest.raises(ModelError, match=rf"^{name}\[1, 2\]: {bad!r} was given"):
            method(values)
    with pytest.raises(ModelError, match=rf"^force\[2\]: {bad!r} was given"):
        law.indentation([0.0, 1.0, bad])


@EVERY
@pytest.mark.parametrize("bad", ["deep", "1e-6", None, {}, [[1.0], [1.0, 2.0]], 1e-6 + 1e-6j, np.array([1e-6 + 1e-6j])])
def test_what_is_no_number(law, bad):
    with pytest.raises(ModelError, match=r"^delta: .*expected a number or an array of numbers"):
        law.force(bad)


@EVERY
def test_ranges_of_validity(law):
    if law.limit == math.inf:
        assert law.force(1.0) > 0.0
        return
    inside = np.array([0.5, 1.0]) * law.limit
    assert np.isfinite(law.force(inside)).all()
    if law.limit < law.end:
        with pytest.raises(ModelError, match=r"^delta\[1\]: .*range of validity of .*lenient=True"):
            law.force([0.0, law.limit * 1.001])


def lenient(law):
    return {
        Hertz: lambda: Hertz.spheres(0.01, 0.02, STEEL, lenient=True),
    }.get(type(law), lambda: type(law)(PIN, lenient=True))()


@pytest.mark.parametrize("law", [law for law in LAWS if law.limit < law.end], ids=lambda law: type(law).__name__)
def test_lenient_laws_warn_up_to_their_end(law):
    law = lenient(law)
    beyond = law.limit * 1.001
    for method in (law.force, law.stiffness, law.energy):
        with pytest.warns(
            ModelWarning, match=rf"^delta: {beyond!r} was given, {type(law).__name__} is valid up to"
        ) as told:
            assert method(beyond) > 0.0
        assert told[0].filename == __file__
    with pytest.warns(ModelWarning, match=r"^delta\[1\]: .*is valid up to"):
        force = law.force([0.0, beyond])[1]
    with pytest.warns(ModelWarning, match=r"^force: .*is valid up to"):
        assert law.indentation(force) == pytest.approx(beyond, rel=1e-12)
    if law.end < math.inf:
        with pytest.raises(ModelError, match=rf"^delta: .*where {type(law).__name__} ends"):
            law.force(law.end * 1.0001)
        with pytest.raises(ModelError, match=rf"^force: .*where {type(law).__name__} ends"):
            law.indentation(1e12)


@pytest.mark.parametrize("bad", [0.0, -1.0, math.nan, math.inf, "steel", None])
def test_radii_lengths_and_stiffnesses_that_are_none(bad):
    makes = {
        "hole_radius": lambda: CylinderPair.internal(bad, 0.1, 0.1, STEEL),
        "pin_radius": lambda: CylinderPair.internal(0.1, bad, 0.1, STEEL),
        "length": lambda: CylinderPair.internal(0.1, 0.09, bad, STEEL),
        "radius": lambda: CylinderPair.external(bad, 0.1, 0.1, STEEL),
        "other_radius": lambda: CylinderPair.external(0.1, bad, 0.1, STEEL),
        "cup_radius": lambda: Hertz.sphere_in_cup(0.1, bad, STEEL),
        "stiffness": lambda: PowerLaw(bad),
        "exponent": lambda: PowerLaw(1.0, bad),
    }
    for name, make in makes.items():
        with pytest.raises(ModelError, match=rf"^{name}: {bad!r} was given, expected a finite number"):
            make()
    for make in (lambda: Hertz.spheres(bad, 0.1, STEEL), lambda: Hertz.sphere_on_plane(bad, STEEL)):
        with pytest.raises(ModelError, match=rf"^radius: {bad!r} was given"):
            make()
    with pytest.raises(ModelError, match=rf"^other_radius: {bad!r} was given"):
        Hertz.spheres(0.1, bad, STEEL)


@pytest.mark.parametrize("bad", [0.0, -1.0, math.nan, -math.inf, "steel", None])
def test_moduli_that_are_none(bad):
    with pytest.raises(ModelError, match=rf"^youngs_modulus: {bad!r} was given"):
        Material(bad, 0.3)


@pytest.mark.parametrize("bad", [-1.0, 0.5, 0.7, -2.0, math.nan, math.inf, "x"])
def test_poissons_ratios_that_are_none(bad):
    with pytest.raises(
        ModelError, match=rf"^poissons_ratio: {bad!r} was given, expected a finite number in \(-1, 0.5\)"
    ):
        Material(2e11, bad)


@pytest.mark.parametrize(
    "make", [lambda *m: Hertz.spheres(0.1, 0.1, *m), lambda *m: CylinderPair.external(1, 1, 1, *m)]
)
def test_materials_that_are_none(make):
    with pytest.raises(ModelError, match=r"^material: 200000000000.0 was given, expected a Material"):
        make(2e11)
    with pytest.raises(ModelError, match=r"^other: 'steel' was given, expected a Material"):
        make(STEEL, "steel")
    rigid = Material(math.inf, 0.0)
    with pytest.raises(ModelError, match=r"^material, other: two rigid ones"):
        make(rigid)
    make(rigid, STEEL)


@pytest.mark.parametrize("hole", [0.0079, 0.005])
def test_pins_that_do_not_fit(hole):
    with pytest.raises(ModelError, match=r"^pin_radius: 0.0079 m was given, expected less than hole_radius"):
        CylinderPair.internal(hole, 0.0079, 0.01, STEEL)
    with pytest.raises(ModelError, match=r"^radius: 0.0079 m was given, expected less than cup_radius"):
        Hertz.sphere_in_cup(0.0079, hole, STEEL)


@pytest.mark.parametrize("law", LINES)
def test_pairs_that_are_none(law):
    for bad in (None, 0.1, CylinderPair, (PIN,)):
        with pytest.raises(ModelError, match=r"^pair: .*expected a CylinderPair"):
            law(bad)


@pytest.mark.parametrize("law", [Esdu78035, Liu, Persson])
def test_laws_of_pins_in_holes(law):
    with pytest.raises(ModelError, match=r"^pair: cylinders side by side were given, expected a pin in a hole"):
        law(SIDE)


def test_esdu_of_cylinders_side_by_side():
    with pytest.warns(ModelWarning, match=r"^pair: cylinders side by side") as told:
        Esdu78035(SIDE, lenient=True)
    assert told[0].filename == __file__


@pytest.mark.parametrize("reading", ["PI", "h", None, 1])
def test_readings(reading):
    with pytest.raises(ModelError, match=rf'^reading: {reading!r} was given, expected "pi" or "review"'):
        Esdu78035(PIN, reading)


@pytest.mark.parametrize(
    ("law", "name", "bads"), [(Goldsmith, "m", (0.5, 5.0)), (LankaraniNikraveshCylinder, "exponent", (0.9, 2.0))]
)
def test_exponents(law, name, bads):
    for bad in (*bads, math.nan, "x"):
        with pytest.raises(ModelError, match=rf"^{name}: {bad!r} was given"):
            law(PIN, **{name: bad})
    with pytest.raises(ModelError, match=r"^exponent: 0.5 was given"):
        PowerLaw(1.0, 0.5)


def test_clearances_of_pereira():
    for clearance in (4e-6, 10.1e-3):
        pair = CylinderPair.internal(0.1 + clearance, 0.1, 0.01, STEEL)
        with pytest.raises(ModelError, match=rf"^pair: a clearance of {1e3 * clearance:g} mm was given"):
            Pereira(pair)
    with pytest.warns(ModelWarning, match=r"^pair: a clearance of 10.1 mm") as told:
        Pereira(pair, lenient=True)
    assert told[0].filename == __file__
    with pytest.raises(ModelError, match=r"^pair: a clearance of 0.004 mm"):
        Pereira(CylinderPair.internal(0.100004, 0.1, 0.01, STEEL), lenient=True)
    for clearance in (5e-6, 10e-3):  # the ends themselves, though the difference of radii is rounded
        Pereira(CylinderPair.internal(0.1 + clearance, 0.1, 0.01, STEEL))


def test_persson_of_two_materials():
    pair = CylinderPair.internal(0.008, 0.0079, 0.01, STEEL, ALUMINIUM)
    with pytest.raises(ModelError, match=r"^pair: two materials were given, expected one"):
        Persson(pair)
    with pytest.warns(ModelWarning, match=r"^pair: two materials"):
        Persson(pair, lenient=True)
    Persson(CylinderPair.internal(0.008, 0.0079, 0.01, STEEL, Material(207e9, 0.3)))


def test_angles_of_persson():
    for bad in (-0.1, math.radians(80.0), math.nan):
        with pytest.raises(ModelError, match=r"^eps: .*expected 0 to 1.37881 rad"):
            Persson(PIN).force_at_angle([0.1, bad])
    with pytest.raises(ModelError, match=r"^eps: 'wide' was given, expected a number"):
        Persson(PIN).force_at_angle("wide")
    law = Persson(PIN, lenient=True)
    with pytest.warns(ModelWarning, match=r"^eps: .*checked up to"):
        assert law.force_at_angle(math.radians(83.0)) > law.force_at_angle(1.37)
    with pytest.raises(ModelError, match=r"^eps: "):
        law.force_at_angle(math.radians(84.8))


# --- units


@pytest.mark.parametrize("law", LINES)
def test_cylinders_in_newtons_and_millimetres(law):
    pair = CylinderPair.internal(8.0, 7.995, 10.0, Material(207e3, 0.3))
    with pytest.raises(
        ModelError, match=r"207000 Pa and 8 m .*look like MPa and mm.* such as 2.07e\+11 Pa and 0.008 m"
    ):
        law(pair)
    with pytest.warns(ModelWarning, match="look like MPa and mm") as told:
        law(pair, lenient=True)
    assert told[0].filename == __file__


def test_spheres_in_newtons_and_millimetres():
    for make in (
        lambda **k: Hertz.spheres(15.0, 20.0, Material(210e3, 0.3), **k),
        lambda **k: Hertz.sphere_on_plane(15.0, Material(5.0, 0.49), **k),
        lambda **k: Hertz.sphere_in_cup(15.0, 30.0, Material(210e3, 0.3), Material(math.inf, 0.0), **k),
    ):
        with pytest.raises(ModelError, match="look like MPa and mm"):
            make()
        with pytest.warns(ModelWarning, match="look like MPa and mm") as told:
            make(lenient=True)
    assert told[0].filename == __file__


def test_length_in_millimetres_beside_radii_in_metres():
    with pytest.warns(ModelWarning, match=r"^length: 10 m was given, which looks like mm beside radii of") as told:
        Johnson(CylinderPair.internal(0.068, 0.0079, 10.0, STEEL))
    assert told[0].filename == __file__
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        Johnson(CylinderPair.external(0.3, 0.4, 10.0, STEEL))  # rolls of a paper machine
        Johnson(CylinderPair.external(1e-4, 1e-4, 0.5, STEEL))  # wires side by side


def test_flags_that_are_none():
    makes = [*(lambda law=law: law(PIN, lenient="no") for law in LINES), lambda: PowerLaw(1e6, lenient=2)]
    for make in (*makes, lambda: Hertz.spheres(0.1, 0.1, STEEL, lenient=None)):
        with pytest.raises(ModelError, match=r"^lenient: .* was given, expected True or False"):
            make()
    with pytest.raises(ModelError, match=r"^handbook: 'yes' was given, expected True or False"):
        Radzimovsky(PIN, "yes")


def test_numbers_in_words():
    """They would be kept as they are, and fail where they are computed with."""
    for make in (lambda: PowerLaw("1e6"), lambda: Goldsmith(PIN, m="3"), lambda: Material("2e11", 0.3)):
        with pytest.raises(ModelError, match=r"^\w+: '.*' was given, expected a finite number"):
            make()


@pytest.mark.parametrize("points", [10.5, 1000.0, 9, "20", None, math.nan])
def test_points_of_a_fit(points):
    with pytest.raises(ModelError, match=rf"^points: {points!r} was given, expected a whole number"):
        fit_power_law(Johnson(PIN), (0.0, 5e3), points=points)


def test_laws_are_written_as_they_are_made():
    for law in (PowerLaw(1e6, 1.25), PowerLaw(2.0, lenient=True)):
        assert eval(repr(law)) == law


def test_millimetres_beside_pascals():
    with pytest.warns(ModelWarning, match=r"^radius: all radii are 52 m or more"):
        Johnson(CylinderPair.external(52.0, 60.0, 10.0, STEEL))


@pytest.mark.parametrize(
    ("radii", "material"),
    [
        ((0.001, 0.002), Material(5e3, 0.49)),  # a gel
        ((0.02, 0.03), Material(1e5, 0.4)),  # a foam
        ((0.3, 0.9), RUBBER),
        ((2.0, 5.0), RUBBER),  # tyre of a dumper
        ((4.0, 8.0), STEEL),  # a mill in its ring
        ((0.46, 300.0), STEEL),  # a wheel on the crown of a rail
        ((1e-6, 2e-6), Material(1e12, 0.1)),  # diamond
    ],
)
def test_sound_bodies_pass(radii, material):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        Hertz.spheres(*radii, material)
        Hertz.sphere_on_plane(radii[0], material)
        Johnson(CylinderPair.external(*radii, 0.1, material))
        Liu(CylinderPair.internal(radii[1], radii[0], 0.1, material))
