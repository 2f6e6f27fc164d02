"""Two trajectories that another program publishes, met row by row.

Rows of the reference files of the Siconos examples (Apache-2.0): Woodpecker.ref and ImpactingBar.ref.
"""

from __future__ import annotations

import numpy as np
import pytest

from lcpflex import Result, gallery, simulate

TOLERANCE = 1e-9

# t, y, ydot, phi_M, phi_Mdot, phi_S, phi_Sdot; step 2e-5
WOODPECKER = np.array([
    (0.00098, -0.0003307591949722178, -0.333802927516779, -0.1036, 0.0, -0.2861545580058103, -7.551641431857),
    (0.07798, -0.007030333269422415, -0.1194949262639024, 0.1034692624118988, -0.4152313284407716,
     0.06791888218320187, 16.77647215161953),
    (0.07998, -0.007220444627568734, -0.09345533601881717, 0.09414037042802441, -6.080097458727519,
     0.102266441992864, 17.30614537660463),
    (0.08098, -0.007330947689033112, -0.1331725478272243, 0.08956678920688693, -2.369587786709741,
     0.1194317259094263, 16.95920732385728),
    (0.08198, -0.007374261824062836, 0.06858287416010582, 0.1035802836008786, 0.0,
     0.1129863772362792, -6.24162935833604),
    (0.12098, -0.01050970759134811, -0.3057763354731491, -0.1029804354808285, -0.4342660764384387,
     -0.1110429623769285, -6.227135624991504),
    (0.20098, -0.02388345040694624, 0.0, -0.1034542612275354, 0.0, -0.3146533796001462, 16.78483206457495),
    (0.22698, -0.02679984545137359, -0.1294470510035522, 0.08986824429257419, -2.776759382079629,
     0.1181535796524239, 16.97856646599261),
    (0.22798, -0.02685484157477388, 0.06899713567587572, 0.1036536427485139, 0.0,
     0.1131032302285511, -6.245638065374619),
    (0.29998, -0.04134818676833654, -0.2601373307913771, -0.1034684682717361, 0.0,
     -0.3409339755504301, -8.327555353239312),
])  # fmt: skip

# t (from 1e-8), q_0, v_0, impulse of the step / step, twice the elastic and kinetic energy, q_L, v_L; step 2e-6
BAR = np.array([
    (2.01e-06, 4.98e-05, -0.1, 0.0, 0.0, 0.02424708, 4.98e-05, -0.1),
    (0.00050401, -2.999999999997902e-07, 0.0, 727.132071909911, 5.552644912766867e-05, 0.02404612713649035,
     -3.999999999997926e-07, -0.1),
    (0.00050601, -2.999999999997902e-07, 0.0, 1110.528982553283, 0.0003100853901202175, 0.0237915681954978,
     -5.999999999997866e-07, -0.1),
    (0.00060001, -2.999999999997928e-07, 0.0, 1270.140047018045, 0.01225432171869725, 0.01184733186692074,
     -9.999999999999789e-06, -0.1),
    (0.00088601, -2.99999999999801e-07, 0.0, 347.9042510752803, 0.0001451419442975066, 0.02395651164132049,
     -1.634408097212838e-07, 0.102137268718309),
    (0.00088801, -2.988112358878078e-07, 0.001188764111993168, 0.0, 0.000205490532861662, 0.02389616305275633,
     4.306425768371306e-08, 0.1043677986866829),
    (0.00120001, 3.096273614389188e-05, 0.1038198980270009, 0.0, 0.0002802230166599924, 0.023821430568958,
     3.067080015061179e-05, 0.08751366036446025),
    (0.00149601, 6.000091122626505e-05, 0.09497655627264671, 0.0, 0.0003747070383498478, 0.02372694654726807,
     5.958663498135018e-05, 0.08676275060270563),
])  # fmt: skip


@pytest.fixture(scope="module")
def woodpecker() -> Result:
    case = gallery.scenes()["woodpecker"]
    return simulate(case.build(), 0.39, case.stepper, record=0.0)


@pytest.fixture(scope="module")
def impacting_bar() -> Result:
    case = gallery.scenes()["impacting_bar"]
    return simulate(case.build(), case.duration, case.stepper, record=0.0)


def test_woodpecker_follows_the_published_trajectory(woodpecker: Result) -> None:
    rows = np.rint(WOODPECKER[:, 0] / 2e-5).astype(int)
    assert woodpecker.times[rows] == pytest.approx(WOODPECKER[:, 0], abs=1e-12)
    assert woodpecker.q[rows] == pytest.approx(WOODPECKER[:, 1::2], abs=TOLERANCE)
    assert woodpecker.u[rows] == pytest.approx(WOODPECKER[:, 2::2], abs=TOLERANCE)
    assert woodpecker.energies.relative_remainder < 1e-12


def test_woodpecker_pecks_and_descends(woodpecker: Result) -> None:
    """The published step of 2e-5 s leaves an error of first order in the times."""
    reference = gallery.scenes()["woodpecker"].reference
    beak = woodpecker.contact("beak")
    pecks = beak.times[1:][np.diff(beak.impulse[:, 0]) > 0.0]
    first, second, third = (pecks[pecks > after][0] for after in (0.0, 0.15, 0.3))
    assert first == pytest.approx(reference["first_peck"], abs=5e-5)
    assert second == pytest.approx(reference["second_peck"], abs=2.5e-4)
    assert third == pytest.approx(reference["third_peck"], abs=2.5e-4)
    height = np.interp([second, third], woodpecker.times, woodpecker.q[:, 0])
    assert third - second == pytest.approx(reference["period"], abs=2.5e-4)
    assert height[0] - height[1] == pytest.approx(reference["descent"], abs=1e-4)


def test_impacting_bar_follows_the_published_trajectory(impacting_bar: Result) -> None:
    result = impacting_bar
    rows = np.rint((BAR[:, 0] - 1e-8) / 2e-6).astype(int)
    assert result.q[rows][:, [0, -1]] == pytest.approx(BAR[:, [1, 6]], abs=TOLERANCE)
    assert result.u[rows][:, [0, -1]] == pytest.approx(BAR[:, [2, 7]], abs=TOLERANCE)
    assert result.force[rows, 0, 0] == pytest.approx(BAR[:, 3], abs=TOLERANCE)
    assert 2.0 * result.energies.elastic[rows] == pytest.approx(BAR[:, 4], abs=TOLERANCE)
    assert 2.0 * result.energies.kinetic[rows] == pytest.approx(BAR[:, 5], abs=TOLERANCE)


def test_impacting_bar_rebounds(impacting_bar: Result) -> None:
    result = impacting_bar
    weight = np.asarray(gallery.impacting_bar().mass).sum(axis=1)
    touching = np.flatnonzero(result.force[:, 0, 0] > 0.0)
    reference = gallery.scenes()["impacting_bar"].reference
    assert result.times[touching[0]] + 1e-8 == pytest.approx(reference["first_contact"], abs=1e-8)
    assert result.times[touching[-1]] + 1e-8 == pytest.approx(reference["last_contact"], abs=1e-8)
    impulse = result.impulse[-1, 0, 0] / (weight.sum() * 0.1)
    assert impulse == pytest.approx(reference["relative_impulse"], abs=5e-6)
    assert weight @ result.u[-1] / weight.sum() == pytest.approx(reference["rebound"], abs=5e-7)
    assert result.energies.stored[-1] / result.energies.stored[0] == pytest.approx(0.99400, abs=5e-6)
