"""Advice on meshes, modes and steps before a run, and warnings after one that broke it."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

import lcpflex as lf
from lcpflex import meshes
from lcpflex.bodies.continuum import Continuum
from lcpflex.bodies.reduction.component_modes import unreduced
from lcpflex.checks import resolution_rules as advice
from lcpflex.checks.resolution import _push, unresolved
from tests.scenes import floor_of

pytestmark = pytest.mark.filterwarnings("ignore:mesh. its stiffness:lcpflex.errors.ModelWarning")  # coarse on purpose

STEEL = {"density": 7800.0, "youngs_modulus": 2.1e11}
BALL = 4.0 / 3.0 * math.pi * 0.015**3 * 7780.0  # [kg]


# ---- numbers


def test_a_steel_ball_on_a_rigid_wall():
    """Closed form of Hertz' impact: duration, compression and force of a ball of 30 mm at 1 m/s."""
    modulus = advice.effective_modulus((210e9, 0.3))
    assert advice.contact_time(BALL, 0.015, modulus, 1.0) == pytest.approx(7.828287e-5, rel=1e-6)
    told = advice.contact_advice(BALL, 0.015, modulus, 1.0, 5000.0)
    assert told.peak_force == pytest.approx(5169.114, rel=1e-6)
    assert told.radius == pytest.approx(math.sqrt(0.015 * 2.659720e-5), rel=1e-6)  # a^2 = R delta


def test_the_duration_is_that_of_the_equation_of_motion():
    """m x'' = -K x^(3/2), by quadrature of 2 dx / sqrt(v^2 - 4 K x^(5/2) / (5 m)), x = delta sin^2."""
    m, radius, modulus, v = 0.3, 0.02, 4e10, 2.0
    K = 4.0 / 3.0 * modulus * math.sqrt(radius)
    delta = (1.25 * m * v * v / K) ** 0.4
    nodes, weights = np.polynomial.legendre.leggauss(60)
    angle = 0.25 * math.pi * (nodes + 1.0)
    s = np.sin(angle) ** 2
    rate = 2.0 * np.sin(angle) * np.cos(angle) / np.sqrt(1.0 - s**2.5)
    expected = 2.0 * delta / v * 0.25 * math.pi * float(weights @ rate)
    assert advice.contact_time(m, radius, modulus, v) == pytest.approx(expected, rel=1e-9)


def test_effective_numbers_of_two_bodies():
    assert advice.effective(2.0, math.inf) == 2.0
    assert advice.effective(2.0, 2.0) == 1.0
    soft, hard = (69e9, 0.33), (210e9, 0.3)
    together = advice.effective_modulus(soft, hard)
    assert 1.0 / together == pytest.approx(1.0 / advice.effective_modulus(soft) + 1.0 / advice.effective_modulus(hard))


@pytest.mark.parametrize("fraction", [0.3, 0.1, 0.02])
def test_no_frequency_beyond_the_excited_ones_gets_more_than_the_fraction(fraction):
    """Against the Fourier transform of a half sine; the lobe next to the limit comes near it."""
    T = 2e-4
    limit = advice.excited_frequency(T, fraction)
    t = np.linspace(0.0, T, 4001)
    pulse = np.sin(math.pi * t / T)

    def share(f):
        return abs(np.trapezoid(pulse * np.exp(-2j * math.pi * f * t), t)) / (2.0 * T / math.pi)

    beyond = max(share(f) for f in np.linspace(limit, limit + 2.0 / T, 200))
    assert 0.4 * fraction < beyond < fraction * (1.0 + 1e-4)
    assert share(0.4 * limit) > fraction


def test_elements_along_the_impact_are_a_quarter_as_long():
    """Chen, Liu & Hong 2015: 8.5 mm for 30 kHz, and a quarter of that in the direction of the impact."""
    told = advice.contact_advice(BALL, 0.015, advice.effective_modulus((210e9, 0.3)), 1.0, 5100.0, 3200.0)
    assert told.size_along_impact == pytest.approx([0.25 * size for size in told.size_elsewhere])
    assert f"of at most {250.0 * told.size_elsewhere[0]:.3g} mm and" in str(told)


def test_elements_and_pairs():
    assert advice.wave_speed(69e9, 2700.0) == pytest.approx(5055.25, rel=1e-6)
    assert advice.element_size(30e3, 5100.0) == pytest.approx(8.5e-3)  # Chen, Liu & Hong 2015: 8.5 mm for 30 kHz
    assert advice.element_size(30e3, 5100.0, per_wavelength=10.0) == pytest.approx(17e-3)
    assert advice.contact_radius(467.78, 0.015, advice.effective_modulus((210e9, 0.3), (69e9, 0.33))) == pytest.approx(
        4.5e-4, rel=0.01
    )
    assert advice.contact_pairs(8e-4, 2e-4) == 9
    assert advice.contact_pairs(8e-4, 1e-4, half_section=True) == 9
    assert advice.contact_pairs(8e-4, 2.01e-4) == 7


def test_advice_can_be_read_and_followed():
    told = advice.contact_advice(BALL, 0.015, 6e10, 0.3, 5055.0, 5195.0, half_section=True)
    assert advice.contact_pairs(told.radius, told.size_at_contact, half_section=True) == advice.PAIRS
    assert told.size_elsewhere[0] == advice.element_size(told.frequency, 5055.0)
    assert told.step * told.frequency == pytest.approx(1.0 / 20.0)
    text = str(told)
    assert all(part in text for part in ("Hertz", "kHz", "radius", "9 pairs", "mm", "us"))
    assert len(text.splitlines()) == 5


def test_modes_are_counted_without_computing_them():
    plate = Continuum(meshes.rectangle(0.3, 0.02, 30, 2, order=1), poissons_ratio=0.3, **STEEL)
    known = unreduced(plate).frequencies() / (2.0 * math.pi)
    for count in (1, 4, 9, 40):
        between = 0.5 * (known[count - 1] + known[count])
        assert advice.modes_needed(plate, between) == count
        assert advice.modes_needed(plate.reduce(modes=count + 1), between) == count
    assert advice.modes_needed(plate, 0.5 * known[0]) == 0
    assert advice.modes_needed(lf.Disc(radius=0.1, mass=1.0), 1e3) == 0
    beam = lf.Beam(length=0.3, width=0.02, thickness=0.02, elements=10, **STEEL)
    assert advice.modes_needed(beam, 1.01 * beam.reduce(modes=4).frequencies()[3] / (2.0 * math.pi)) == 4
    with pytest.raises(lf.ModelError, match=r"body: its 5 modes end at .* expected some above"):
        advice.modes_needed(plate.reduce(modes=5), 1.01 * known[4])


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: advice.wave_speed(-1.0, 1.0), "youngs_modulus: -1.0"),
        (lambda: advice.element_size(0.0, 5000.0), "frequency: 0.0"),
        (lambda: advice.effective(0.0, 1.0), "first: 0.0 .* infinite for a wall"),
        (lambda: advice.effective_modulus((2e11, 0.6)), "first: Poisson's ratio: 0.6"),
        (lambda: advice.effective_modulus((2e11, 0.3), 2e11), "second: .*expected .Young's modulus"),
        (lambda: advice.contact_time(1.0, 1.0, 1e9, 0.0), "speed: 0.0"),
        (lambda: advice.excited_frequency(1.0, 1.0), "fraction: 1.0"),
        (lambda: advice.contact_advice(1.0, 1.0, 1e9, 1.0), "wave_speeds: none"),
        (lambda: advice.modes_needed("beam", 1.0), "body: 'beam'"),
    ],
)
def test_what_cannot_be(call, message):
    with pytest.raises(lf.ModelError, match=message):
        call()


# ---- pairs in contact, and warnings


def pressed(nodes, modes=None, resolution=True):
    """A meshed steel block falls flat onto the ground with its lower face, a chain of so many nodes."""
    mesh = meshes.rectangle(0.04, 0.02, nodes - 1, 4, order=1)
    body = Continuum(mesh, poissons_ratio=0.3, **STEEL).reduce(modes=modes)
    scene = lf.Scene(gravity=(0.0, 0.0))
    block = scene.add(body if resolution else replace(body, resolution=None), "block", velocity=(0.0, -0.1))
    scene.contact(block.surface("bottom"), floor_of(scene), name="ground")
    return scene


def run(scene, duration=3e-5):
    return lf.simulate(scene, duration, lf.GeneralizedAlpha(step=5e-8))


def test_pairs_in_contact_over_time():
    """While a wave goes up and down the block, all nodes of its lower face carry force; before and after none."""
    result = run(pressed(11))
    pairs = result.contact("ground").pairs
    assert pairs.shape == result.times.shape
    assert pairs.max() == 11
    assert pairs[-1] == 0
    np.testing.assert_array_equal(pairs > 0, result.contact("ground").force[:, 0] > 0.0)


@pytest.mark.parametrize(("nodes", "warned"), [(11, False), (9, False), (8, True), (5, True)])
def test_fewer_than_nine_pairs_are_said(nodes, warned):
    texts = [text for text in run(pressed(nodes)).warnings if "pairs of touching points" in text]
    assert len(texts) == warned
    if warned:
        assert f"'ground': {nodes} pairs" in texts[0]
        assert "at least 9: make the elements of 'block'" in texts[0]
        assert f"{9 / nodes:.2g} times as fine" in texts[0]


@pytest.mark.parametrize("node", [False, True])
def test_a_disc_on_a_coarse_mesh_is_said(node):
    """The disc is the node side where nothing is chosen; a half-plane on the mesh has nothing that could be finer."""
    scene = pressed(11)
    disc = scene.add(lf.Disc(radius=0.02, mass=0.1), "disc", position=(0.0205, 0.04), velocity=(0.0, -0.2))
    top = scene.body("block").surface("top")
    scene.contact(disc.surface(), top, name="disc", node_side=top if node else None)
    (text,) = (text for text in run(scene).warnings if "'disc'" in text and "at least 9" in text)
    assert "make the elements of 'block'" in text
    assert ("choose that surface as the node side" in text) is not node
    flat = pressed(11)
    disc = flat.add(lf.Disc(radius=0.02, mass=0.1), "disc", position=(0.0205, 0.04), velocity=(0.0, -0.2))
    flat.contact(disc.surface(), flat.body("block").half_plane((0.02, 0.02), (0.0, 1.0)), name="disc")
    assert not [text for text in run(flat).warnings if "'disc'" in text and "at least 9" in text]


def test_what_is_no_mesh_is_not_told_to_refine():
    assert not run(pressed(5, resolution=False)).warnings


def test_too_long_elements_and_too_few_modes_are_said():
    """The same contact, on a mesh of 5 mm elements, then with two modes."""
    result = run(pressed(11))
    duration = 2.0 * 0.02 / 5900.0  # about: a wave up and down
    allowed = advice.element_size(advice.excited_frequency(duration), advice.wave_speed(2.1e11, 7800.0))
    assert 0.5e-3 < allowed < 2e-3
    (text,) = (text for text in result.warnings if "20 to a wave" in text)
    assert "elements of 'block' are up to 0.00" in text
    fine = replace(result.compiled.layout, resolutions=((5188.0, 5e-4),))
    assert not unresolved(replace(result, compiled=replace(result.compiled, layout=fine)))
    (text,) = (text for text in run(pressed(11, modes=2)).warnings if "keep more" in text)
    assert "modes of 'block' (2) end at" in text


def test_static_modes_do_not_count():
    """The free modes of a block that falls on its residual compliance: 3 dynamic ones end below what is excited."""
    mesh = meshes.rectangle(0.04, 0.02, 10, 4, order=1)
    body = lf.residual_compliance(Continuum(mesh, poissons_ratio=0.3, **STEEL), "bottom", modes=30)
    scene = lf.Scene(gravity=(0.0, 0.0))
    block = scene.add(body, "block", velocity=(0.0, -0.1))
    scene.contact(block.surface("bottom"), floor_of(scene), name="ground")
    for modes, warned in ((3, True), (30, False)):
        result = lf.simulate(scene, 3e-5, lf.MasslessBoundary(dynamic_modes=modes), record=3e-8)
        texts = [text for text in result.warnings if "keep more" in text]
        assert len(texts) == warned
        if warned:
            assert f"dynamic modes of 'block' ({modes}) end at" in texts[0]


def test_nothing_is_said_of_what_is_not_known():
    """A push that had not ended with the run, or that the stored instants do not resolve."""
    assert not any("20 to a wave" in text for text in run(pressed(11), duration=4e-6).warnings)
    coarse = lf.simulate(pressed(11), 3e-5, lf.GeneralizedAlpha(step=5e-8), record=5e-6)
    assert not any("20 to a wave" in text for text in coarse.warnings)


def test_resolutions_survive_on_disk(tmp_path):
    result = run(pressed(11), duration=1e-6)
    loaded = lf.Result.load(result.save(tmp_path / "run.npz"))
    assert loaded.compiled.layout.resolutions == result.compiled.layout.resolutions
    assert loaded.compiled.layout.resolutions[0][0] == pytest.approx(math.sqrt(2.1e11 / 7800.0))


def test_an_event_during_a_push_does_not_end_it():
    """Events store their instant twice, before and after, with the same impulse: a push goes on over them."""
    times, impulse = np.linspace(0.0, 3.0, 31), np.clip(np.linspace(-1.0, 2.0, 31), 0.0, 1.0)
    assert _push(times, impulse) == pytest.approx(1.0)
    twice = np.sort(np.append(np.arange(31), [13, 15]))
    assert _push(times[twice], impulse[twice]) == pytest.approx(1.0)
