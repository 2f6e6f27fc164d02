"""What restitution comes out of dissipative laws: printed values, closed forms against integration, and inverses."""

from __future__ import annotations

import decimal
import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from lcpflex.errors import ModelError
from lcpflex.force_laws.damping.dissipative import (
    Jankowski,
    KelvinVoigt,
    KuwabaraKono,
    PermanentIndentation,
    Ristow,
    Tsuji,
)
from lcpflex.force_laws.damping.hysteresis import HysteresisFactor
from lcpflex.force_laws.damping.rebound import exact_factor, rebound_of_drag, rebound_of_factor, rebound_of_ratio
from lcpflex.force_laws.damping.restitution import prescribed_restitution, restitution_of

F = HysteresisFactor
PRESCRIBED = (0.1, 0.3, 0.5, 0.7, 0.9, 0.99)
TABLE = {
    F.EXACT: PRESCRIBED,
    F.HUNT_CROSSLEY: (0.5158, 0.5813, 0.6630, 0.7680, 0.9090, 0.9901),
    F.HERBERT_MCWHANNELL: (0.4907, 0.5200, 0.5936, 0.7227, 0.9009, 0.9900),
    F.LEE_WANG: (0.6867, 0.7390, 0.7992, 0.8693, 0.9524, 0.9950),
    F.LANKARANI_NIKRAVESH: (0.6653, 0.6842, 0.7252, 0.7960, 0.9132, 0.9901),
    F.GONTHIER: (0.1010, 0.3042, 0.4877, 0.6696, 0.8764, 0.9868),
    F.ZHIYING_QISHAO: (0.2175, 0.3267, 0.4826, 0.6796, 0.8959, 0.9900),
    F.FLORES: (0.0694, 0.2562, 0.4704, 0.6832, 0.8939, 0.9893),
    F.GHARIB_HURMUZLU: (0.1000, 0.2819, 0.4107, 0.5008, 0.5668, 0.5911),
    F.HU_GUO: (0.0741, 0.2707, 0.4877, 0.6973, 0.8999, 0.9900),
    F.CARVALHO_MARTINS: (0.1289, 0.3040, 0.5002, 0.7000, 0.9000, 0.9900),
    F.SAFAEIFAR_FARSHIDIANFAR: (0.0889, 0.3138, 0.5362, 0.7350, 0.9152, 0.9917),
    F.ZHANG: (0.0954, 0.3017, 0.5081, 0.7057, 0.9009, 0.9900),
    F.YE: (0.0741, 0.2707, 0.4877, 0.6973, 0.8999, 0.9900),
    F.PANT: (0.0067, 0.0659, 0.2171, 0.4770, 0.8093, 0.9801),
    KelvinVoigt: (0.2527, 0.3971, 0.5503, 0.7182, 0.9020),
    Tsuji: (0.2527, 0.3971, 0.5503, 0.7182, 0.9020),
    PermanentIndentation: PRESCRIBED,
}
EVERY = [*F, KelvinVoigt, Tsuji, Jankowski, PermanentIndentation, KuwabaraKono, Ristow]


def name(law: Any) -> str:
    return str(getattr(law, "name", getattr(law, "__name__", law)))


def free_impact(
    force: Callable[[float, float], float], mass: float, speed: float, depth: float, *, pulls: bool
) -> tuple[float, float]:
    """v_out/v_0 and the largest indentation over ``depth``, integrated until bodies part, or the force would pull."""

    def slope(_: float, y: Any) -> tuple[float, float]:
        return y[1], -force(depth * max(y[0], 0.0), speed * y[1]) * depth / (mass * speed**2)

    def over(_: float, y: Any) -> float:
        if y[1] >= 0.0:
            return 1.0
        return force(depth * y[0], speed * y[1]) * depth / (mass * speed**2) if pulls and y[0] > 0.0 else float(y[0])

    def turn(_: float, y: Any) -> float:
        return float(y[1])

    over.terminal = True  # type: ignore[attr-defined]
    path = solve_ivp(
        slope, (0.0, 1e3), (0.0, 1.0), method="DOP853", rtol=1e-12, atol=1e-15, events=(over, turn), max_step=0.1
    )
    assert path.status == 1
    return -float(path.y[1, -1]), float(path.y_events[1][0, 0])


@pytest.mark.parametrize("law", TABLE, ids=name)
def test_printed_values(law: Any) -> None:
    wanted = TABLE[law]
    np.testing.assert_allclose(restitution_of(law, PRESCRIBED[: len(wanted)]), wanted, rtol=0.0, atol=6e-5)


def test_reference_values_at_0_8() -> None:
    found = [restitution_of(law, 0.8) for law in (F.HUNT_CROSSLEY, F.LANKARANI_NIKRAVESH, F.FLORES)]
    np.testing.assert_allclose(found, (0.8329, 0.8471, 0.7885), rtol=0.0, atol=6e-5)


def test_exact_factor() -> None:
    e = np.array((0.1, 0.3, 0.5, 0.7, 0.9))
    np.testing.assert_allclose(
        F.EXACT.eta(e), (9.9981594, 3.0870820, 1.4327505, 0.6348283, 0.1664820), rtol=0.0, atol=6e-8
    )
    fine = np.concatenate((np.geomspace(1e-12, 0.01, 40), np.linspace(0.01, 1.0, 400), 1.0 - np.geomspace(1e-12, 1e-2)))
    np.testing.assert_allclose(rebound_of_factor(exact_factor(fine)), fine, rtol=3e-12)
    assert exact_factor(1.0) == 0.0


@pytest.mark.parametrize("e", [1e-6, 0.02, 0.4, 0.95, 0.987, 0.989, 1.0 - 1e-7])
def test_exact_factor_in_forty_digits(e: float) -> None:
    """Newton's method for s = ln(1 - e eta), as eta crowds at 1/e."""
    with decimal.localcontext() as context:
        context.prec = 40
        exact = decimal.Decimal(e)
        guess = decimal.Decimal(exact_factor(e))
        left = 1 - exact * guess
        s = left.ln() if left > decimal.Decimal("1e-14") else -(1 + 1 / exact)
        for _ in range(20):
            eta = (1 - s.exp()) / exact
            slope = -s.exp() / exact
            s -= ((1 + eta).ln() - s - eta * (1 + exact)) / (slope / (1 + eta) - 1 - slope * (1 + exact))
        eta = (1 - s.exp()) / exact
        assert abs((1 + eta).ln() - s - eta * (1 + exact)) < decimal.Decimal("1e-30")
        assert float(guess / eta - 1) == pytest.approx(0.0, abs=1e-11)


@pytest.mark.parametrize("eta", [0.019999, 0.02, 0.020001])
def test_series_and_closed_form_meet(eta: float) -> None:
    e = rebound_of_factor(eta)
    assert math.log1p(eta) - math.log1p(-e * eta) - eta * (1.0 + e) == pytest.approx(0.0, abs=1e-15)


@pytest.mark.parametrize(
    ("eta", "n", "stiffness", "mass", "speed"),
    [
        (0.01, 1.5, 1e9, 0.1, 1.0),
        (0.4, 1.0, 3e4, 7.0, 0.02),
        (1.4327505, 1.5, 4e10, 0.11, 5.0),
        (6.0, 2.7, 1e3, 1.0, 0.3),
    ],
)
def test_hysteresis_in_closed_form(eta: float, n: float, stiffness: float, mass: float, speed: float) -> None:
    """e(eta), and delta_m^(n+1) = (n+1) (m v0^2/K) (eta - ln(1+eta))/eta^2."""
    depth = (mass * speed**2 / stiffness) ** (1.0 / (n + 1.0))
    e, deepest = free_impact(lambda d, v: stiffness * d**n * (1.0 + eta * v / speed), mass, speed, depth, pulls=False)
    assert e == pytest.approx(rebound_of_factor(eta), rel=1e-9)
    assert deepest ** (n + 1.0) == pytest.approx((n + 1.0) * (eta - math.log1p(eta)) / eta**2, rel=1e-9)


def test_phase_plane() -> None:
    """delta^(n+1) = (n+1) (m v0^2/(K eta^2)) [eta (1-w) - ln((1+eta)/(1+eta w))] with w = v/v0."""
    eta, n = 0.8, 1.5
    path = solve_ivp(
        lambda _, y: (y[1], -(max(y[0], 0.0) ** n) * (1.0 + eta * y[1])), (0.0, 2.5), (0.0, 1.0), "DOP853", rtol=1e-12,
        atol=1e-14,
    )  # fmt: skip
    d, w = path.y[:, path.y[0] >= 0.0]
    assert w.min() < -0.4
    closed = (n + 1.0) / eta**2 * (eta * (1.0 - w) - np.log((1.0 + eta) / (1.0 + eta * w)))
    np.testing.assert_allclose(d ** (n + 1.0), closed, rtol=0.0, atol=1e-9)


@pytest.mark.parametrize("e", [0.0, 0.2, 0.6, 0.95])
@pytest.mark.parametrize("n", [1.0, 1.5, 2.0])
def test_oscillators_in_closed_form(e: float, n: float) -> None:
    """Kelvin-Voigt (n = 1) and Tsuji: c = sqrt(2 (n+1)) zeta sqrt(m K) delta^((n-1)/2), until the force is zero."""
    zeta = -math.log(e) / math.hypot(math.pi, math.log(e)) if e > 0.0 else 1.0
    alpha = math.sqrt(2.0 * (n + 1.0)) * zeta
    stiffness, mass, speed = 2e7, 3.0, 0.7
    depth = (mass * speed**2 / stiffness) ** (1.0 / (n + 1.0))
    found, _ = free_impact(
        lambda d, v: stiffness * d**n + alpha * math.sqrt(mass * stiffness) * d ** ((n - 1.0) / 2.0) * v,
        mass,
        speed,
        depth,
        pulls=True,
    )
    assert found == pytest.approx(restitution_of(Tsuji, e), rel=1e-9)
    assert found == pytest.approx(restitution_of(KelvinVoigt, e), rel=1e-9)


def test_overdamped_oscillators() -> None:
    assert rebound_of_ratio(1.0) == pytest.approx(math.exp(-2.0), rel=1e-15)
    assert rebound_of_ratio(1.0 - 1e-9) == pytest.approx(math.exp(-2.0), rel=1e-8)
    assert rebound_of_ratio(1.0 + 1e-12) == pytest.approx(math.exp(-2.0) * (1.0 - 4e-12 / 3.0), rel=1e-14)
    p = math.sqrt(3.0)
    assert rebound_of_ratio(2.0) == pytest.approx(math.exp(-4.0 / p * math.atanh(p / 2.0)), rel=1e-14)


@pytest.mark.parametrize("parameter", [0.03, 0.4, 1.2])
def test_kuwabara_kono_and_ristow_against_integration(parameter: float) -> None:
    stiffness, mass, speed = 3e8, 0.4, 2.0
    depth = (mass * speed**2 / stiffness) ** 0.4
    A = parameter / ((stiffness / mass) ** 0.4 * speed**0.2)
    found, _ = free_impact(
        lambda d, v: stiffness * (d**1.5 + 1.5 * A * math.sqrt(d) * v), mass, speed, depth, pulls=True
    )  # fmt: skip
    assert restitution_of(KuwabaraKono, parameter) == pytest.approx(found, rel=1e-9)
    gamma = parameter / ((mass / stiffness) ** 0.4 * speed**-0.2)
    found, _ = free_impact(lambda d, v: stiffness * d**1.5 + gamma * mass * v, mass, speed, depth, pulls=True)
    assert restitution_of(Ristow, parameter) == pytest.approx(found, rel=1e-9)


@pytest.mark.parametrize(
    ("law", "slope", "powers"),
    [(KuwabaraKono, 1.7301733, (0.0, 1.0, 1.5, 2.0)), (Ristow, 1.7878141, (0.0, 2 / 3, 1.0, 4 / 3, 5 / 3))],
    ids=name,
)
def test_series_of_weak_drag(law: Any, slope: float, powers: tuple[float, ...]) -> None:
    """e = 1 - C A' + ...; the clip, at delta ~ A' and delta^(3/2) ~ g', brings roots of them."""
    parameters = np.geomspace(1e-4, 1e-2, 9)
    slopes = (1.0 - restitution_of(law, parameters)) / parameters
    limit = np.linalg.lstsq(parameters[:, None] ** np.array(powers), slopes)[0][0]
    assert limit == pytest.approx(slope, rel=1e-5)


def test_drag_of_power_zero_is_the_oscillator() -> None:
    zeta = np.array((0.05, 0.5, 0.9, 1.5))
    np.testing.assert_allclose(rebound_of_drag(2.0 * zeta, 0.0), rebound_of_ratio(zeta), rtol=1e-10)


@pytest.mark.parametrize("e", [0.1, 0.45, 0.8, 1.0])
def test_jankowski_against_integration(e: float) -> None:
    xi = 4.5 * math.sqrt(5.0) * (1.0 - e**2) / (e * (e * (9.0 * math.pi - 16.0) + 16.0))
    stiffness, mass, speed = 3e8, 0.4, 2.0
    depth = (mass * speed**2 / stiffness) ** 0.4

    def force(d: float, v: float) -> float:
        return stiffness * d**1.5 + (2.0 * xi * math.sqrt(mass * stiffness) * d**0.25 * v if v > 0.0 else 0.0)

    found, _ = free_impact(force, mass, speed, depth, pulls=False)
    assert restitution_of(Jankowski, e) == pytest.approx(found, rel=1e-9)


def test_jankowski_is_near_what_is_prescribed() -> None:
    e = np.linspace(0.001, 1.0, 1000)
    off = np.abs(restitution_of(Jankowski, e) - e)
    assert 0.008 < off.max() <= 0.009


@pytest.mark.parametrize("law", EVERY, ids=name)
def test_inverse(law: Any) -> None:
    e = np.array(((0.25,), (0.8,)))
    back = prescribed_restitution(law, restitution_of(law, e))
    assert back.shape == e.shape
    np.testing.assert_allclose(back, e, rtol=1e-9)
    scalar = prescribed_restitution(law, restitution_of(law, 0.6))
    assert isinstance(scalar, float)
    assert scalar == pytest.approx(0.6, rel=1e-9)


@pytest.mark.parametrize("law", [*F, KelvinVoigt, Tsuji, Jankowski, PermanentIndentation], ids=name)
def test_inverse_over_the_whole_reach(law: Any) -> None:
    """Near the least e_out of KelvinVoigt its e falls from 1e-12 to 1e-100, and all of that is resolved."""
    least = restitution_of(law, 0.0) if law in (KelvinVoigt, Tsuji) or not getattr(law, "needs_rebound", True) else 0.0
    most = restitution_of(law, 1.0)
    out = least + (most - least) * np.array([1e-4, 1e-3, 0.01, 0.1, 0.5, 0.9, 1.0 - 1e-6])
    np.testing.assert_allclose(restitution_of(law, prescribed_restitution(law, out)), out, rtol=1e-12)


@pytest.mark.parametrize("law", [F.EXACT, F.FLORES, Jankowski, PermanentIndentation], ids=name)
def test_inverse_of_hardly_any_restitution(law: Any) -> None:
    assert restitution_of(law, prescribed_restitution(law, 1e-30)) == pytest.approx(1e-30, rel=1e-12)


@pytest.mark.parametrize("law", [*F, KelvinVoigt, Tsuji, Jankowski, PermanentIndentation], ids=name)
def test_what_comes_out_grows_with_what_is_prescribed(law: Any) -> None:
    assert np.all(np.diff(restitution_of(law, np.linspace(0.002, 1.0, 500))) > 0.0)


@pytest.mark.parametrize(
    ("law", "out", "named"),
    [
        (F.HUNT_CROSSLEY, 0.3, "0.487"),
        (F.LEE_WANG, 0.5, "0.66296"),
        (F.GHARIB_HURMUZLU, 0.8, "0.5936"),
        (KelvinVoigt, 0.1, "0.1353"),
        (F.EXACT, 1.2, "1"),
        (F.EXACT, math.nan, "1"),
    ],
)
def test_what_cannot_come_out(law: Any, out: float, named: str) -> None:
    with pytest.raises(ModelError, match="e_out") as error:
        prescribed_restitution(law, out)
    assert named in str(error.value)


@pytest.mark.parametrize("law", [F.EXACT, F.FLORES, F.ZHANG, F.PANT, F.GHARIB_HURMUZLU, Jankowski], ids=name)
def test_no_restitution_zero_for_laws_that_diverge_there(law: Any) -> None:
    with pytest.raises(ModelError, match=r"restitution: .*0\.0"):
        restitution_of(law, np.array((0.5, 0.0)))


@pytest.mark.parametrize("law", [F.EXACT, F.HUNT_CROSSLEY, Tsuji, PermanentIndentation], ids=name)
@pytest.mark.parametrize("e", [-0.1, 1.1, math.nan])
def test_restitution_out_of_range(law: Any, e: float) -> None:
    with pytest.raises(ModelError, match="restitution"):
        restitution_of(law, e)


@pytest.mark.parametrize("law", [F.EXACT, Tsuji, KuwabaraKono, PermanentIndentation], ids=name)
def test_what_is_no_number(law: Any) -> None:
    with pytest.raises(ModelError, match=r"^(restitution|parameter): 'low' was given, expected a number"):
        restitution_of(law, "low")
    with pytest.raises(ModelError, match=r"^e_out: 'low' was given, expected a number"):
        prescribed_restitution(law, "low")


@pytest.mark.parametrize("law", [KuwabaraKono, Ristow], ids=name)
@pytest.mark.parametrize("parameter", [-1.0, math.inf])
def test_parameter_out_of_range(law: Any, parameter: float) -> None:
    with pytest.raises(ModelError, match="parameter"):
        restitution_of(law, parameter)


@pytest.mark.parametrize("law", ["exact", Tsuji(0.5), float, None], ids=str)
def test_what_is_no_law(law: Any) -> None:
    with pytest.raises(ModelError, match="law: "):
        restitution_of(law, 0.5)
    with pytest.raises(ModelError, match="law: "):
        prescribed_restitution(law, 0.5)


@pytest.mark.parametrize("law", [*F, Jankowski, KelvinVoigt, Tsuji, PermanentIndentation])
@pytest.mark.parametrize("e", [5e-324, 1e-320, 1e-308, 1e-300, 1e-200, 1e-155, 1e-30])
def test_tiny_restitution_has_a_rebound_or_an_error(law, e):
    endless = law in (Jankowski, PermanentIndentation) or (law in list(F) and law.needs_rebound)
    if endless and (e < 1e-300 or (law is F.PANT and e < 1e-154)):  # the rebound of PANT goes with the square of e
        with pytest.raises(ModelError, match=f"^restitution: {e} was given, expected"):
            restitution_of(law, e)
    else:
        assert 0.0 <= restitution_of(law, e) <= 1.0


def test_jankowski_is_linear_in_a_tiny_restitution():
    exact = 8.0 / 9.0  # e_out = 1 / (2 zeta) = 8 e / 9 for a small e
    for e in (1e-299, 1e-250, 1e-154, 1e-100, 1e-20):
        assert restitution_of(Jankowski, e) == pytest.approx(exact * e, rel=1e-12)


@pytest.mark.parametrize("law", [KuwabaraKono, Ristow])
def test_strong_drag_leaves_a_positive_rebound_or_is_refused(law):
    found = [restitution_of(law, strength) for strength in (1e3, 1e4, 1e5, 1e6)]
    assert np.all(np.diff(found) < 0.0)
    assert found[-1] > 0.0
    for strength in (1e7, 1e100, 1e300):
        with pytest.raises(ModelError, match=r"^parameter: .* expected numbers in \[0, 1e\+06\]"):
            restitution_of(law, strength)
