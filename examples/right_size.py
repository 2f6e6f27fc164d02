"""How few modes will do? A hammer falls onto a strip between two supports: rigid, a few modes, or the full mesh?

Both bodies can be had at any fidelity: rigid, 1, 2, 4, ... modes, the full mesh. ``right_size`` compares them with one
run of the full meshes (or, where that is dear, one far up the levels, extrapolated to them), raises only the body whose
refinement changes what is asked for, and stops where the error that is left is below the tolerance. The stout hammer
(80 x 30 x 30 mm, steel) may be rigid; the slender strip (0.8 m x 30 mm x 8 mm), which it strikes at 1 m/s, may not. In
the picture: error against cost.
"""

from pathlib import Path

import lcpflex as lf
from lcpflex.studies import right_size

TOLERANCE = 0.05  # of where both bodies are, and of the impulse between them
DURATION = 0.02
STEPPER = lf.GeneralizedAlpha(step=4e-6)


def steel(length: float, thickness: float, elements: int) -> lf.Beam:
    return lf.Beam(length, width=0.03, thickness=thickness, density=7800.0, youngs_modulus=2.1e11, elements=elements)


def hammer_on_strip() -> lf.Scene:
    scene = lf.Scene()
    few = {"modes": 2, "damping": 0.02}
    strip = scene.add(steel(0.8, 0.008, elements=30), "strip", **few)
    hammer = scene.add(steel(0.08, 0.03, elements=6), "hammer", (0.26, 0.0191), velocity=(0.0, -1.0), **few)
    scene.join(lf.Revolute(strip.point("left"), scene.ground.at(0.0, 0.0)))
    scene.join(lf.PointOnLine(strip.point("right"), scene.ground.at(0.8, 0.0), axis=(1.0, 0.0)))
    scene.contact(hammer.node(0.04, -0.015), strip.surface("top"), name="strike")
    return scene


def run(folder: Path = Path()) -> lf.Result:
    found = right_size(hammer_on_strip, tolerance=TOLERANCE, duration=DURATION, stepper=STEPPER)
    print(found)

    result = lf.simulate(found.scene, DURATION, STEPPER)
    whole = {name: found.scene.body(name).source.fidelity_levels()[-1].make() for name in found.levels}
    full = lf.simulate(found.scene.with_bodies(whole), DURATION, STEPPER)
    impulse, exact = (one.contact("strike").impulse[-1, 0] for one in (result, full))
    print(f"impulse {impulse:.4f} N s, of the full meshes {exact:.4f} N s")

    assert found.levels["hammer"] == "rigid"
    assert abs(impulse / exact - 1.0) < TOLERANCE

    found.plot().savefig(folder / "right_size.png", dpi=150)
    return result


if __name__ == "__main__":
    print(run().summary())
