"""Force laws declared with contacts: checked, carried through compilation and exchange of bodies."""

import pytest

import lcpflex as lf
from lcpflex.errors import ModelError
from lcpflex.force_laws.contact_law import ContactLaw
from lcpflex.force_laws.penalty import Penalty
from tests.scenes import floor_of

LAW = Penalty(stiffness=1e5, exponent=1.5)


def two_balls() -> tuple[lf.Scene, list]:
    """Two discs above the ground, none declared to touch."""
    scene = lf.Scene()
    balls = [scene.add(lf.Disc(0.1, 1.0), f"ball{k}", position=(0.5 * k, 0.2)) for k in range(2)]
    return scene, balls


def test_laws_are_carried_to_the_compiled_scene_and_its_system():
    scene, (a, b) = two_balls()
    floor = floor_of(scene)
    scene.contact(a.surface(), floor, law=LAW, name="soft")
    scene.contact(b.surface(), floor, restitution=0.5, name="hard")
    compiled = scene.compiled()
    assert compiled.laws == (LAW, None)
    assert compiled.system().laws == (LAW, None)
    assert scene.with_bodies({"ball0": lf.Disc(0.1, 2.0)}).compiled().laws == (LAW, None)


@pytest.mark.parametrize("soft", [0, 1, 2])
def test_kernels_serve_scenes_with_and_without_laws_alike(soft):
    """Types of another kind would have everything compiled once more, which takes minutes."""
    scene, balls = two_balls()
    floor = floor_of(scene)
    for k, ball in enumerate(balls):
        scene.contact(ball.surface(), floor, law=LAW if k < soft else None)
    plain, _ = two_balls()
    ours, theirs = (made.compiled().system() for made in (scene, plain))
    assert ours.workspace(4)._type == theirs.workspace(4)._type
    assert ours.model._type == theirs.model._type
    assert ours.recorder(4, 4)._type == theirs.recorder(4, 4)._type


def test_rules_carry_laws_and_declared_contacts_go_before_them():
    scene, (a, _) = two_balls()
    floor = floor_of(scene)
    scene.contact(a.surface(), floor, name="hard")
    scene.contact_all(friction=0.1, law=LAW)
    compiled = scene.compiled()
    assert dict(zip(compiled.layout.contacts, compiled.laws, strict=True))["hard"] is None
    assert compiled.laws[1:] == (LAW, LAW)
    assert scene.with_bodies({"ball0": lf.Disc(0.1, 2.0)}).compiled().laws == compiled.laws


@pytest.mark.parametrize("law", [1e5, Penalty, "hertz"])
def test_what_is_no_law_is_refused(law):
    scene, (a, b) = two_balls()
    with pytest.raises(ModelError, match=r"law: .* expected a force law"):
        scene.contact(a.surface(), b.surface(), law=law)
    with pytest.raises(ModelError, match=r"law: .* expected a force law"):
        scene.contact_all(law=law)


def test_restitution_does_not_go_with_a_law():
    scene, (a, b) = two_balls()
    with pytest.raises(ModelError, match=r"^restitution: 0.5 .* expected 0"):
        scene.contact(a.surface(), b.surface(), restitution=0.5, law=LAW)
    with pytest.raises(ModelError, match=r"^tangential_restitution: 0.5 .* expected 0"):
        scene.contact_all(tangential_restitution=0.5, law=LAW)


def test_saved_results_leave_laws_out(tmp_path):
    scene, (a, b) = two_balls()
    scene.contact(a.surface(), b.surface(), law=LAW)
    result = lf.simulate(scene, 1e-3, lf.Smooth(LAW), record=0.0)
    assert result.compiled.laws == (LAW,)
    assert lf.Result.load(result.save(tmp_path / "run.npz")).compiled.laws == (None,)


def test_a_law_of_three_parts_is_taken():
    class Linear:
        kind, parameters, limit, end, lenient = 0, (1e5, 1.0), float("inf"), float("inf"), False

    scene, (a, b) = two_balls()
    law = ContactLaw(Linear())
    scene.contact(a.surface(), b.surface(), law=law)
    assert scene.compiled().laws == (law,)
