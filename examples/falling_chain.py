"""A long chain falls onto the floor: sixty hinges and up to a hundred and twenty contacts in one island.

Hinges are exact, not springs: in free fall they carry nothing, and nothing has to be damped out of them. The factor of
their equations has the pattern of the chain, so that its cost grows with the number of links. When the chain meets the
floor, at one end first, impulses run along it; at rest the floor carries its weight, and the hinges what friction left.
"""

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

import lcpflex as lf
from lcpflex import gallery

LINKS = 60


def run(folder: Path = Path()) -> lf.Result:
    scene = gallery.link_chain(links=LINKS, degrees=20.0)
    result = lf.simulate(scene, 1.5, lf.MoreauJean(step=5e-4), record=5e-3)
    weight = LINKS * 0.1 * 9.81
    floor = result.impulse[:, :, 0].sum(axis=1)
    momentum = 0.1 * result.u[:, 1::3].sum(axis=1)
    assert np.abs(floor - weight * result.times - momentum).max() < 1e-8 * floor[-1]
    hinges = [result.reaction(f"joint {k + 1}") for k in range(LINKS - 1)]
    falls = (result.times > 0.0) & (result.times < 0.15)
    assert max(np.abs(hinge.force[falls]).max() for hinge in hinges) < 1e-8 * weight

    figure = Figure(figsize=(9, 7), layout="constrained")
    rows = figure.subplots(3, 1, height_ratios=(1.2, 1, 1))
    for t, shade in zip((0.0, 0.2, 0.4, 0.6, 1.5), (0.75, 0.6, 0.4, 0.2, 0.0), strict=True):
        k = int(np.argmin(np.abs(result.times - t)))
        rows[0].plot(result.q[k, 0::3], result.q[k, 1::3], color=str(shade), label=f"{t:g} s")
    rows[0].axhline(0.0, color="brown", linewidth=0.8)
    rows[0].set(xlabel="x [m]", ylabel="y [m]", aspect="equal")
    rows[0].legend(ncols=5, loc="lower right")
    middle = 0.5 * (result.times[1:] + result.times[:-1])
    rows[1].plot(middle, np.diff(floor) / np.diff(result.times) / weight)
    rows[1].axhline(1.0, color="gray", linestyle=":")
    rows[1].set(xlabel="time [s]", ylabel="force of the floor / weight")
    struck = np.array([np.linalg.norm(np.diff(hinge.impulse, axis=0), axis=1) for hinge in hinges])
    image = rows[2].pcolormesh(middle, np.arange(1, LINKS), struck, cmap="magma_r", vmax=np.quantile(struck, 0.995))
    rows[2].set(xlabel="time [s]", ylabel="hinge, from the left")
    figure.colorbar(image, ax=rows[2], label="impulse of impacts in 5 ms [N s]")
    figure.savefig(folder / "falling_chain.png", dpi=120)
    return result


if __name__ == "__main__":
    print(run().summary())
