"""Charts, pictures and films."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pytest

import lcpflex as lf
from lcpflex import gallery
from lcpflex.errors import ModelError
from lcpflex.jit.kernel import FloatArray
from lcpflex.results.chart_words import stepper_words, told_apart
from lcpflex.results.charts import shown_forces
from lcpflex.results.result import Result
from tests import libs
from tests.scenes import floor_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes


def test_chart_shows_forces_gaps_and_energies_with_units(swing: Result) -> None:
    figure = swing.plot()
    assert [ax.get_ylabel() for ax in figure.axes] == ["contact force [N]", "gap [m]", "energy [J]"]
    assert figure.axes[-1].get_xlabel() == "time [s]"
    line = next(line for line in figure.axes[0].lines if line.get_label() == "disc on floor, tangential")
    np.testing.assert_array_equal(line.get_ydata(), -2.0)


def test_chart_scales_units(bounce: Result) -> None:
    figure = replace(bounce, gap=1e-3 * bounce.gap, force=bounce.force + 5e4).plot()
    assert [ax.get_ylabel() for ax in figure.axes] == ["contact force [kN]", "gap [µm]", "energy [J]"]
    assert np.nanmax(np.asarray(figure.axes[0].lines[0].get_ydata())) == pytest.approx(50.0)


def test_legends_stand_beside_the_data(swing: Result) -> None:
    figure = swing.plot()
    figure.savefig("/dev/null", format="png")
    for ax in figure.axes:
        legend = ax.get_legend()
        assert legend is not None
        box = legend.get_window_extent()
        assert box.x0 >= ax.get_window_extent().x1
        assert box.x1 <= figure.bbox.x1


def test_picture_shows_the_deformed_outline(swing: Result) -> None:
    """The corner of the beam is drawn where it is at that instant, with equal axes."""
    figure = swing.draw(0.2)
    ax = figure.axes[0]
    assert ax.get_aspect() == 1.0
    corner = swing.point("pendulum", (0.7, 0.01))[20]
    distance = min(np.linalg.norm(np.column_stack(line.get_data()) - corner, axis=1).min() for line in ax.lines)
    assert distance < 1e-12
    ax_limits = (*ax.get_xlim(), *ax.get_ylim())
    assert ax_limits[0] < corner[0] < ax_limits[1]
    assert ax_limits[2] < corner[1] < ax_limits[3]


def arrows(ax: Axes) -> tuple[FloatArray, FloatArray]:
    """Feet and tips (k, 2) of the arrows drawn, the key first."""
    drawn = [text for text in ax.texts if isinstance(text, libs.Annotation)]
    return np.array([text.xyann for text in drawn]), np.array([text.xy for text in drawn])


def test_picture_has_an_arrow_for_the_force_and_a_key(swing: Result) -> None:
    """Along N n + T t with n = (0, 1), t = (1, 0): 9.81 N up and 2 N to the left; as long as the key says."""
    ax = swing.draw(0.2).axes[0]
    feet, tips = arrows(ax)
    assert len(feet) == 2
    np.testing.assert_allclose(feet[1], (0.5 + 0.2 * 0.2, -0.9), atol=1e-12)
    newton = np.linalg.norm(tips[0] - feet[0]) / 10.0
    assert "10 N" in {text.get_text().strip() for text in ax.texts}
    np.testing.assert_allclose(tips[1] - feet[1], newton * np.array([-2.0, 9.81]), atol=1e-12)


@pytest.mark.parametrize("chain", [False, True])
def test_forces_are_drawn_on_the_upper_body_whichever_side_has_the_nodes(chain: bool) -> None:
    """Two boxes and the ground: weight is carried upwards. Chains test their nodes against each other both ways."""
    scene = lf.Scene()
    lower = scene.add(lf.Box(width=0.3, height=0.1, mass=1.0), name="lower", position=(0.0, 0.05))
    upper = scene.add(lf.Box(width=0.2, height=0.1, mass=1.0), name="upper", position=(0.0, 0.15))
    step = [(0.1, 0.0), (-0.1, 0.0)]  # narrower than the box: its ends are the nodes that touch
    ground = scene.ground.chain(step) if chain else floor_of(scene)
    scene.contact(lower.surface(), ground, friction=0.5)
    scene.contact(upper.surface(), lower.surface(), friction=0.5)
    result = lf.simulate(scene, 0.01, lf.MoreauJean(step=1e-3))
    feet, tips = arrows(result.draw(0.01).axes[0])
    assert len(feet) == 5
    assert (tips[1:, 1] > feet[1:, 1] + 1e-3).all()


def test_rods_without_outlines_are_drawn_as_lines_between_their_joints() -> None:
    result = lf.simulate(gallery.double_pendulum(), 1e-3, lf.MoreauJean(step=1e-3))
    ax = result.draw(0.0).axes[0]
    ends = {tuple(np.round(line.get_xydata()[-1], 9)) for line in ax.lines if len(line.get_xydata()) == 2}
    for rod, end in (("upper rod", "top"), ("upper rod", "bottom"), ("lower rod", "bottom")):
        assert tuple(np.round(result.point(rod, end)[0], 9)) in ends
    low = ax.get_ylim()[0]
    assert low < result.point("lower rod", "bottom")[0, 1]


def test_holes_are_left_open_and_their_edges_are_known() -> None:
    ring = lf.Continuum(lf.meshes.ring(0.05, 0.1, 16, 1), 1000.0, 1e9, 0.3).reduce(2)
    scene = lf.Scene(gravity=(0, 0))
    scene.add(ring, name="ring", velocity=(1.0, 0.0))
    result = lf.simulate(scene, 1e-3, lf.MoreauJean(step=1e-4))
    (body,) = [patch.get_path() for patch in result.draw(0.0).axes[0].patches if len(patch.get_path()) == 2 * 33]
    areas = [0.5 * float(x[:-1] @ y[1:] - x[1:] @ y[:-1]) for x, y in (loop.T for loop in body.to_polygons())]
    assert areas[0] > 0.0 > areas[1]  # around the other way: not filled
    assert result.velocity("ring", (0.05, 0.0))[-1] == pytest.approx([1.0, 0.0])


def test_surfaces_on_a_rigid_body_are_drawn_as_they_are() -> None:
    """A closed chain is filled, an open one is a line, and no line runs from the origin to their corners."""
    scene = lf.Scene()
    floor = floor_of(scene)
    body = scene.add(lf.RigidBody(mass=1.0, inertia=0.01), name="body", position=(0.0, 0.2))
    corners = [(-0.1, -0.1), (0.1, -0.1), (0.12, 0.1)]
    hook = [(0.3, 0.1), (0.3, 0.0), (0.4, 0.0)]
    scene.contact(body.chain(corners, closed=True), floor)
    scene.contact(body.chain(hook), floor)
    ax = lf.simulate(scene, 1e-3, lf.MoreauJean(step=1e-3)).draw(0.0).axes[0]
    (filled,) = [patch for patch in ax.patches if len(patch.get_path().vertices) == 4 and patch.get_alpha() == 0.2]
    np.testing.assert_allclose(filled.get_path().vertices[:3], np.add(corners, (0.0, 0.2)), atol=1e-12)
    sides = [tuple(np.round(side, 9).ravel()) for group in ax.collections for side in group.get_segments()]
    assert {(0.3, 0.3, 0.3, 0.2), (0.3, 0.2, 0.4, 0.2)} <= set(sides)
    ends = [np.round(line.get_xydata()[-1], 9).tolist() for line in ax.lines if len(line.get_xydata()) == 2]
    assert all([x, y + 0.2] not in ends for x, y in corners + hook)


def test_bodies_of_discs_are_joined_to_their_hinges() -> None:
    scene = lf.Scene()
    club = scene.add(lf.RigidBody(mass=1.0, inertia=0.01), name="club", position=(0.6, 0.5))
    scene.join(lf.Revolute(club.at(-0.2, 0.0), scene.ground.at(0.4, 0.5)))
    scene.contact(club.circle((0.2, 0.0), 0.05), floor_of(scene))
    ax = lf.simulate(scene, 1e-3, lf.MoreauJean(step=1e-3)).draw(0.0).axes[0]
    ends = [np.round(line.get_xydata()[-1], 9).tolist() for line in ax.lines if len(line.get_xydata()) == 2]
    assert [0.4, 0.5] in ends
    assert [0.8, 0.5] in ends


def test_ground_that_is_near_is_shown() -> None:
    """An endless floor below a ball in the air belongs to the picture; one far away does not."""
    for height, shown in ((0.25, True), (2.0, False)):
        scene = lf.Scene()
        ball = scene.add(lf.Disc(radius=0.1, mass=1.0), position=(0.0, height))
        scene.contact(ball.surface(), floor_of(scene))
        low = lf.simulate(scene, 1e-3, lf.MoreauJean(step=1e-3)).draw(0.0).axes[0].get_ylim()[0]
        assert (low < 0.0) == shown


def with_impact(result: Result, times: float) -> Result:
    """``result`` with one contact force that is larger than the others."""
    touching = result.contact_points
    force = touching.force.copy()
    force[0] *= times
    shown = result.force.copy()
    shown[0] *= times
    return replace(result, contact_points=replace(touching, force=force), force=shown)


def test_arrows_have_one_scale_for_a_run_and_end_in_the_picture(swing: Result) -> None:
    """An impact changes no other arrow; its own is cut, stays inside, and tells its force."""
    struck = with_impact(swing, 1e4)
    for plain, hit in zip(arrows(swing.draw(0.2).axes[0]), arrows(struck.draw(0.2).axes[0]), strict=True):
        np.testing.assert_allclose(plain, hit)
    ax = struck.draw(0.0).axes[0]
    feet, tips = arrows(ax)
    (x0, x1), (y0, y1) = ax.get_xlim(), ax.get_ylim()
    assert np.all((tips > (x0, y0)) & (tips < (x1, y1)))
    assert np.linalg.norm(tips - feet, axis=1).max() < 0.5 * max(x1 - x0, y1 - y0)
    assert "100 kN" in {text.get_text().strip() for text in ax.texts}


def test_arrows_in_a_stack_do_not_overlap() -> None:
    scene = lf.Scene()
    below = floor_of(scene)
    for k in range(5):
        box = scene.add(lf.Box(width=0.2, height=0.1, mass=1.0), position=(0.0, 0.05 + 0.1 * k))
        scene.contact(box.surface(), below)
        below = box.surface()
    feet, tips = arrows(lf.simulate(scene, 0.01, lf.MoreauJean(step=1e-3)).draw(0.01).axes[0])
    usual = np.median(np.linalg.norm(tips[1:] - feet[1:], axis=1))
    assert 0.03 < usual < 0.1


def test_one_impact_does_not_press_all_other_forces_onto_the_axis(swing: Result) -> None:
    """The chart is that of the other forces, and says what lies beyond; a force that lasts is not cut."""
    plain, struck = swing.plot(), with_impact(swing, 1e4).plot()
    assert struck.axes[0].get_ylim()[1] < 3.0 * plain.axes[0].get_ylim()[1]
    assert struck.axes[0].get_ylabel() == "contact force [N]"
    legend = struck.axes[0].get_legend()
    assert legend is not None
    words = " ".join(text.get_text() for text in legend.get_texts())
    assert "beyond the axis" in words
    assert "98 kN" in words
    lasting = swing.force.copy()
    lasting[: len(lasting) // 2] *= 1e4
    assert replace(swing, force=lasting).plot().axes[0].get_ylim()[1] > 90.0
    assert shown_forces(lasting) == (pytest.approx(9.81e4), 0)


def test_names_in_legends_stay_apart() -> None:
    names = [f"the left finger of the gripper, joint {k} of its chain" for k in (1, 2)] + ["short"]
    short = told_apart(names)
    assert len(set(short)) == 3
    assert short[2] == "short"
    assert all(len(name) <= 32 for name in short)
    same = told_apart(["x" * 20 + letter + "y" * 20 for letter in "ab"])
    assert same[0] != same[1]


@pytest.mark.parametrize(
    ("stepper", "words"),
    [
        (lf.MoreauJean(step=1e-5), "MoreauJean, step 1e-05 s"),
        (lf.MoreauJean(step=1e-3, theta=1.0), "MoreauJean, step 0.001 s, theta 1.0"),
        (lf.EventDriven(rtol=1e-6), "EventDriven, rtol 1e-06"),
        (lf.Smooth(lf.Penalty(1e6)), "Smooth, law Penalty (stiffness 1000000.0)"),
    ],
)
def test_title_tells_what_is_not_the_default(stepper: object, words: str) -> None:
    assert stepper_words(repr(stepper)) == words


def test_title_of_a_stepper_that_is_not_known() -> None:
    assert stepper_words("Own(step=1.0)") == "Own, step 1.0 s"
    assert stepper_words("<my stepper>") == "<my stepper>"
    assert len(stepper_words("Own(" + "a=1, " * 99 + "b=2)")) <= 100


def test_picture_into_given_axes(swing: Result) -> None:
    figure = libs.Figure()
    ax = figure.subplots()
    assert swing.draw(0.0, ax) is figure


@pytest.mark.parametrize("t", [-0.1, 0.5, math.nan])
def test_picture_of_a_time_that_was_not_simulated(swing: Result, t: float) -> None:
    with pytest.raises(ModelError, match=r"expected a time within the result, 0 to 0\.4 s"):
        swing.draw(t)


def test_picture_of_what_is_no_time(swing: Result) -> None:
    with pytest.raises(ModelError, match="'x' was given"):
        swing.draw("x")  # type: ignore[arg-type]


def test_film_into_a_missing_folder_is_refused_before_it_is_drawn(swing: Result, tmp_path: Path) -> None:
    with pytest.raises(ModelError, match="no folder"):
        swing.animate(tmp_path / "missing" / "film.gif")


def test_film_as_gif(swing: Result, tmp_path: Path) -> None:
    path = swing.animate(tmp_path / "film.gif", fps=10.0, slowdown=2.0)
    with libs.image.open(path) as film:
        assert film.n_frames == 8  # type: ignore[attr-defined]
        assert film.info["duration"] == 100
        first = np.asarray(film.convert("RGB"))
        film.seek(4)
        later = np.asarray(film.convert("RGB"))
    assert (first != later).any(axis=2).mean() > 1e-3  # it moves
    blue = (first[:, :, 2].astype(int) - first[:, :, 0] > 60).mean()
    assert 1e-3 < blue < 0.3  # bodies are there, and what was drawn in one frame is gone in the next
    assert (later[:, :, 2].astype(int) - later[:, :, 0] > 60).mean() == pytest.approx(blue, rel=0.25)


def test_film_as_mp4(swing: Result, tmp_path: Path) -> None:
    if not libs.animation.FFMpegWriter.isAvailable():
        pytest.skip("ffmpeg is not installed")
    path = swing.animate(tmp_path / "film.mp4", fps=10.0, slowdown=1.0)
    assert path.read_bytes()[4:8] == b"ftyp"


def test_film_without_ffmpeg(swing: Result, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(libs.animation.FFMpegWriter, "isAvailable", classmethod(lambda cls: False))
    with pytest.raises(ModelError, match="needs ffmpeg"):
        swing.animate(tmp_path / "film.mp4")


@pytest.mark.parametrize(
    ("name", "options", "words"),
    [
        ("film.avi", {}, r"expected a name that ends in \.gif or \.mp4"),
        ("film.gif", {"fps": 0.0}, "fps: 0.0 was given, expected a finite number in"),
        ("film.gif", {"slowdown": math.nan}, "slowdown: nan"),
        ("missing/film.gif", {}, "cannot write"),
    ],
)
def test_film_that_cannot_be(swing: Result, tmp_path: Path, name: str, options: dict[str, float], words: str) -> None:
    short = replace(swing, duration=0.4)
    with pytest.raises(ModelError, match=words):
        short.animate(tmp_path / name, **{"slowdown": 0.5, **options})


def test_systems_without_shapes_have_charts_but_no_pictures(bounce: Result) -> None:
    assert len(bounce.plot().axes) == 3
    with pytest.raises(ModelError, match="no shapes to draw"):
        bounce.draw(0.1)
