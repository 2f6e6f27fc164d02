"""How many collisions is one collision? As many as the model has modes for, until it has enough of them.

An aluminium strip, hinged at one end, falls level on a fixed hemisphere at 0.4 m/s (strip and speed of Shi, Hong & Liu
2013: 0.7 x 0.028 x 0.005 m, 69 GPa, 2700 kg/m^3). What strikes is not the mass of the strip but a bending wave: the
touching point stops, the rest swings on, pulls it off and throws it back. There are three contacts before it leaves for
good, with a peak near 700 N (they report three within 1.5 ms and a peak on a scale of 500 N); no coefficient of
restitution knows any of it.

Place and radius are not printed; these are chosen: 0.665 m from the hinge (elsewhere it touches more or less often)
and 0.1 m. Openings shorter than 10 us are not counted. The strip is planar, in plane stress with a Poisson's ratio of
0.33: the hemisphere is a cylinder across it. The strip is straight when it touches.

Nodes of the contact region keep their displacements, free modes stand for the rest (sub-regional synthesis); no law of
contact is given. The lowest modes carry mass, all that is above them gives way without any (massless boundary), so that
nothing bounces but the waves. With 10 modes there is one collision, with 20 there are two, with peaks of 270 and 500 N:
with that little a model both are artefacts. From 40 modes on there are 3; with 160 the impulse is right within 0.02 %,
the peak within 6 %, for it is made of the highest frequencies. Nodes decide less, as soon as some share the force.
With more of either, and with contact nodes that carry mass, there are still 3
(``tests/convergence/test_micro_collisions.py``).
"""

from pathlib import Path

from matplotlib.figure import Figure

import lcpflex as lf
from lcpflex.gallery.acceptance.measures import separate_contacts
from lcpflex.gallery.mechanisms.strikers import pendulum_on_hemisphere, strip_with_patch

PARTED = 1e-5  # shorter openings, as there are some, part nothing [s]
NODES = {5: 1e-3, 9: 5e-4, 17: 2.5e-4}  # in the contact region: elements there [m]


def strike(nodes: int, modes: int) -> lf.Result:
    """The first 0.25 ms of the strike."""
    scene = pendulum_on_hemisphere(strip_with_patch(NODES[nodes]), modes)
    return lf.simulate(scene, 2.5e-4, lf.MasslessBoundary(step=2e-7, dynamic_modes=modes), record=2e-7)


def run(folder: Path = Path(), richest: int = 160) -> lf.Result:
    """``richest``: modes of the richest model, 10 doubled twice or more."""
    counts = [10 * 2**k for k in range(12) if 10 * 2**k <= richest]
    by_modes = {modes: strike(9, modes) for modes in counts}
    by_nodes = {nodes: strike(nodes, 40) for nodes in NODES if nodes != 9} | {9: by_modes[40]}
    collisions = {modes: len(separate_contacts(result, PARTED)) for modes, result in by_modes.items()}

    assert collisions[richest] == 3

    figure = Figure(figsize=(11, 7), layout="constrained")
    grid = figure.add_gridspec(2, 3, height_ratios=(1.2, 1.0))
    force = figure.add_subplot(grid[0, :])
    number, peak, nodal = (figure.add_subplot(grid[1, k]) for k in range(3))
    for modes, style in ((10, "C1--"), (40, "C0-"), (richest, "k-")):
        result = by_modes[modes]
        times = 1e6 * result.times
        width = 2.0 if modes == richest else 1.2
        force.plot(times, result.contact("hemisphere").force[:, 0], style, linewidth=width, label=f"{modes} modes")
    number.semilogx(counts, [collisions[modes] for modes in counts], "ks-", base=2)
    peak.semilogx(counts, [by_modes[modes].contact("hemisphere").peak_force for modes in counts], "ko-", base=2)
    nodal.plot(list(NODES), [by_nodes[nodes].contact("hemisphere").peak_force for nodes in NODES], "ko-")
    force.set(xlabel="time since touch [µs]", ylabel="contact force [N]")
    force.legend()
    number.set(xlabel="modes (9 nodes)", ylabel="collisions")
    peak.set(xlabel="modes (9 nodes)", ylabel="peak force [N]")
    nodal.set(xlabel="nodes of the contact region (40 modes)", ylabel="peak force [N]", xticks=list(NODES))
    nodal.set_ylim(0.0, 1.1 * max(result.contact("hemisphere").peak_force for result in by_nodes.values()))
    number.set_yticks(range(1 + max(collisions.values())))
    for axes in (number, peak):
        axes.set_xticks(counts, [str(modes) for modes in counts])
        axes.set_ylim(bottom=0.0)
    for axes in (force, number, peak, nodal):
        axes.grid(True, alpha=0.4)
    figure.savefig(folder / "flexible_pendulum_micro_collisions.png", dpi=150)
    return by_modes[richest]


if __name__ == "__main__":
    print(run().summary())
