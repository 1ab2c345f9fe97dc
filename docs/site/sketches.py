"""One picture for each estimator: the true forces and what it makes of noisy data.

    python docs/site/sketches.py        writes docs/why/sketches/*.png

One packing of 100 grains (μ = 0.3, Δ = 1e-4), its positions known to ξ = Δ, the same noise for
all. `transverse` is told the true normal forces in addition. E stands in each title.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure

from dem import Packing, Scene, relax
from scaling import ContactNetwork, perturb, reconstruct, relative_error

FOLDER = Path(__file__).resolve().parents[1] / "why" / "sketches"
DELTA, SEED, NOISE_SEED = 1e-4, 1, 5
PUSH, PULL = "#1f4e5f", "#c8553d"


def options(packing: Packing) -> dict[str, dict[str, object]]:
    """What each method is told."""
    noise = {"xi": DELTA, "noise": "position"}
    return {
        "gppsz": {},
        "direct": {},
        "transverse": {"normal_forces": packing.normal_forces},
        "balanced": {},
        "optimal": noise,
        "bounded": {**noise, "friction": packing.friction, "pressure": packing.pressure},
    }


def draw(ax: Axes, network: ContactNetwork, normal: np.ndarray, scale: float, title: str) -> None:
    """Contacts as lines as wide as their normal force, red where it pulls."""
    assert network.positions is not None
    start = network.positions[network.pairs[:, 0]]
    ends = start + network.distances[:, None] * network.normals
    colours = [PULL if f < 0 else PUSH for f in normal]
    width = 2.2 * np.abs(normal) / scale
    lines = np.stack([start, ends], axis=1)
    ax.add_collection(LineCollection(lines, linewidths=width, colors=colours))
    ax.set_aspect("equal")
    ax.autoscale_view()
    ax.set_axis_off()
    ax.set_title(title, fontsize=9)


def main() -> None:
    """All six."""
    packing = relax(Scene(grains=100, delta=DELTA), seed=SEED, progress=False)
    network = ContactNetwork.from_packing(packing)
    rng = np.random.default_rng(NOISE_SEED)
    noisy = perturb(network, DELTA, rng, noise="position")
    scale = float(packing.normal_forces.mean())
    FOLDER.mkdir(exist_ok=True)
    for method, told in options(packing).items():
        found = reconstruct(noisy, packing.stiffness, method, **told)
        figure = Figure(figsize=(6.4, 3.3), layout="constrained")
        left, right = figure.subplots(1, 2)
        draw(left, network, packing.normal_forces, scale, "true normal forces")
        error = relative_error(found, packing)
        draw(right, network, found.normal, scale, f"{method}: E = {error:.2g}")
        figure.savefig(FOLDER / f"{method}.png", dpi=120)
        print(method, f"{error:.3g}")


if __name__ == "__main__":
    main()
