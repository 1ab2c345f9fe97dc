"""Studies of the estimators behind docs/estimators.md, one table each.

    python -m benchmarks.estimators [laws] [prefactor] [size] [positions] [ratio] [prior]
                                    [coverage] [stiffness] [time]

laws       gains against loops per contact and hyperstaticity per unknown, over friction and N
prefactor  these laws on packings they were not found on, and the decomposition that explains them
size       the same K²/ℓ over N, and the b of its growth 1 + b/N towards small packings
positions  how fast redundant radii are lost: the bound for noise ξ on diameters, ζ on positions
ratio      balanced over gppsz over N and Δ
prior      what the prior of `bounded` does
coverage   of the credible intervals
stiffness  wrong by one factor, spread over contacts, or the wrong contact law
time       per solve against N, with the exponent

Packings come from the store of the figures; missing ones are made (a minute with Numba).
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Sequence

import numpy as np
from scipy.stats import special_ortho_group

from dem import Packing, Scene, Settings, relax_ensemble
from paper_figs import fig5
from paper_figs.packings import DELTAS, FULL, ROOT, one, seed_of
from scaling import (
    ContactNetwork,
    cramer_rao,
    error_map,
    force_equation,
    forces_of_overlaps,
    perturb,
    reconstruct,
    relative_error,
    tiled,
    to_pressure,
)
from scaling.bounded import Prior, bounded_forces, posterior
from scaling.credible import coverage, enclosing, posterior_draws, widened
from scaling.prefactor import LoopShares, loop_shares, self_stress_gain
from scaling.sources import sources
from scaling.truncated import truncated_draws

SEED = 55


def make(scenes: Sequence[Scene], seeds: Sequence[int]) -> list[Packing]:
    """Packings from the store."""
    store = ROOT / "build" / "packings"
    return relax_ensemble(scenes, seeds, store=store, settings=Settings(), progress=False)


def net(p: Packing) -> ContactNetwork:
    """Its contact network."""
    return ContactNetwork.from_packing(p)


def full(delta: float, k: int = 0) -> Packing:
    """The k-th packing of N = 1000 of the full figures."""
    return one(FULL, delta, seed_of(delta, k))


def laws() -> None:
    """K² over loops per contact and so on, mean ± standard deviation over three packings."""
    groups = {f"N=1000 μ=0.3 Δ={d:g}": [full(d, k) for k in range(3)] for d in DELTAS}
    for d in (1e-2, 1e-4):
        for mu in (0.0, 0.1, 1.0):
            scene = Scene(300, d, friction=mu)
            groups[f"N=300 μ={mu:g} Δ={d:g}"] = make([scene] * 3, range(3))
        for n in (100, 300):
            groups[f"N={n} μ=0.3 Δ={d:g}"] = make([Scene(n, d)] * 3, range(3))
    print("| packings | Z | loops/c | h/unknowns | gppsz K²/(l/c) | balanced K²/h | bound K/h |"
          " gppsz/bound (positions) | balanced/bound |")  # fmt: skip
    print("|---|---|---|---|---|---|---|---|---|")
    everything, smooth = [], []
    for name, packings in groups.items():
        t = np.array([fig5.row(p) for p in packings], fig5.TABLE)
        (everything if t["friction"][0] else smooth).append(t)
        cells = [
            t["Z"], t["loops"], t["hyperstaticity"],
            t["K_gppsz_diameter"] ** 2 / t["loops"],
            t["K_balanced_diameter"] ** 2 / t["hyperstaticity"],
            t["K_optimal_position"] / t["hyperstaticity"],
            t["K_gppsz_position"] / np.maximum(t["K_optimal_position"], 1e-12),
            t["K_balanced_position"] / np.maximum(t["K_optimal_position"], 1e-12),
        ]  # fmt: skip
        text = " | ".join(
            "∞" if v.mean() > 1e6 else f"{v.mean():.3f} ± {v.std(ddof=1):.3f}" for v in cells
        )
        print(f"| {name} | {text} |", flush=True)
    for name, (mean, sd) in fig5.laws(np.concatenate(everything)).items():
        print(f"all with friction: {name} = {mean:.3f} ± {sd:.3f}")
    for name, (mean, sd) in fig5.laws(np.concatenate(smooth)).items():
        print(f"all without: {name} = {mean:.3f} ± {sd:.3f}")
    cut()


SEEN = {
    f"μ={mu:g} Δ={d:g}": Scene(300, d, friction=mu)
    for mu, d in ((0.3, 1e-1), (0.3, 1e-2), (0.3, 1e-4), (0.1, 1e-2), (1.0, 1e-2), (1.0, 1e-4))
}
"""Seeds 0 to 2: the scenes on which the laws were found, by packings of an older integration."""
FRESH = {
    "other seeds, Δ=1e-3": Scene(300, 1e-3),
    "other seeds, Δ=1e-5": Scene(300, 1e-5),
    "Δ=0.03": Scene(300, 3e-2),
    "μ=0.05 Δ=1e-3": Scene(300, 1e-3, friction=0.05),
    "μ=0.2 Δ=1e-3": Scene(300, 1e-3, friction=0.2),
    "μ=0.6 Δ=1e-3": Scene(300, 1e-3, friction=0.6),
    "μ=10 Δ=1e-3": Scene(300, 1e-3, friction=10.0),
    "μ=10 Δ=1e-6": Scene(300, 1e-6, friction=10.0),
    "radii ±15 % Δ=1e-3": Scene(300, 1e-3, polydispersity=0.15),
    "radii ±45 % Δ=1e-3": Scene(300, 1e-3, polydispersity=0.45),
    "N=600 Δ=1e-3": Scene(600, 1e-3),
}
"""Seeds 200 to 207, looked at after K² = ½ ℓ and K = 2.7 h had been written down."""
LAST = {
    "μ=0.4 Δ=3e-3": Scene(300, 3e-3, friction=0.4),
    "μ=0.15 Δ=1e-4": Scene(300, 1e-4, friction=0.15),
    "μ=1 Δ=0.1": Scene(300, 1e-1, friction=1.0),
    "μ=0.1 Δ=3e-2, radii ±20 %": Scene(300, 3e-2, friction=0.1, polydispersity=0.2),
    "μ=3 Δ=1e-4, radii ±40 %": Scene(300, 1e-4, friction=3.0, polydispersity=0.4),
}
"""Seeds 300 to 307, looked at after the curve in Z had been written down too."""


def prefactor() -> None:
    """Candidate laws out of sample, with the exact decomposition of K² that explains them.

    The curve in Z is that of Fig. 5: written down before any of these packings was made.
    """
    seen = [(n, s) for scene in SEEN.values() for n, s in _shares(scene, range(3))]
    Z = np.array([n.coordination for n, _ in seen])
    K = np.array([s.square for _, s in seen]) / (1 - 2 / Z)
    again = np.polynomial.Polynomial.fit(Z, K, 2)
    print(
        f"Fitted again: K²/ℓ = {np.round(again.convert().coef, 4).tolist()} in powers of Z; "
        f"scatter {np.std(K - again(Z)):.4f}, about the old {np.std(K - fig5.curve(Z, 300)):.4f}\n"
    )
    print("| packings | Z | K²/ℓ | from ½ | from the curve | K_d²/ℓ | K_s²/ℓ | ⟨cos θ⟩ |"
          " h <= tr T <= rank Q | floor/K_d² | bound K/h | from 2.7 | ⟨1/λ⟩ |")  # fmt: skip
    print("|---|---|---|---|---|---|---|---|---|---|---|---|---|")
    tests = [(name, scene, 200) for name, scene in FRESH.items()]
    for name, scene, seed in tests + [(name, scene, 300) for name, scene in LAST.items()]:
        found = _shares(scene, range(seed, seed + 8))
        Z = np.array([n.coordination for n, _ in found])
        s = np.array([
            (s.square, s.independent, s.shared, s.turning, s.hyperstaticity, s.leverage,
             s.loops, s.floor / s.independent) for _, s in found
        ])  # fmt: skip
        ell = 1 - 2 / Z
        law, h = s[:, 0] / ell, s[:, 4]
        bound = np.array([_stress_gain(n) for n, _ in found])
        means = s.mean(axis=0)
        print(f"| {name} | {Z.mean():.3f} | {_bar(law)} | {_off(law - 0.5)} | "
              f"{_off(law - fig5.curve(Z, scene.grains))} | "
              f"{_bar(s[:, 1] / ell)} | {_bar(s[:, 2] / ell)} | "
              f"{means[3]:.3f} | {means[4]:.3f} {means[5]:.3f} {means[6]:.3f} | {means[7]:.2f} | "
              f"{_bar(bound / h)} | {_off(bound / h - 2.7)} | {_bar(bound**2 / h)} |",
              flush=True)  # fmt: skip
    mean_field()


def mean_field() -> None:
    """Loops and balance with their own spectra, but turned against each other at random."""
    print("\n| packings | tr T/2c | turned | K_d²/ℓ | turned |\n|---|---|---|---|---|")
    for name, scene in SEEN.items():
        (n, s), *_ = _shares(scene, range(1))
        c, G = n.contacts, force_equation(n)
        M, Q = G.M.toarray(), G.Q.toarray()
        Q = Q @ special_ortho_group(c, seed=SEED).rvs()
        H = M.T @ M
        H[:c, :c] += Q.T @ Q
        T = np.linalg.solve(H, np.vstack([Q.T @ Q, np.zeros((c, c))]))
        ell = n.faces / c
        cells = (
            s.leverage,
            np.trace(T[:c]) / 2 / c,
            s.independent / ell,
            np.sum(T**2) / 4 / c / ell,
        )
        print(f"| {name} | " + " | ".join(f"{v:.3f}" for v in cells) + " |", flush=True)


def _shares(scene: Scene, seeds: Sequence[int]) -> list[tuple[ContactNetwork, LoopShares]]:
    packings = make([scene] * len(seeds), list(seeds))
    return [(n, loop_shares(n)) for n in map(net, packings)]


def _stress_gain(network: ContactNetwork) -> float:
    """K of the bound for position noise per ⟨σ⟩, directions exact in M; nan above Z = 4."""
    try:
        return self_stress_gain(network) / network.mean_diameter
    except ValueError:
        return np.nan


def _bar(values: np.ndarray) -> str:
    """Mean ± standard error."""
    if np.isnan(values).any():
        return ""
    return f"{values.mean():.3f} ± {values.std(ddof=1) / np.sqrt(len(values)):.3f}"


def _off(values: np.ndarray) -> str:
    """Mean over its standard error."""
    if np.isnan(values).any():
        return ""
    return f"{values.mean() / (values.std(ddof=1) / np.sqrt(len(values))):+.1f}"


def size() -> None:
    """K²/ℓ over N, and the fit a (1 + b/N); ± are standard errors over packings, that of b
    multiplied by √(χ² per degree of freedom) where that exceeds 1."""
    counts = {50: 48, 100: 24, 300: 16, 1000: 8, 3000: 4}
    print("| Δ | " + " | ".join(f"N = {n}" for n in counts) + " | b | χ²/3 |")
    print("|---|" + "---|" * (len(counts) + 2))
    for delta in (1e-2, 1e-3, 1e-4):
        found = {n: _loop_gains(delta, n, range(400, 400 + k)) for n, k in counts.items()}
        means = np.array([v.mean() for v in found.values()])
        errors = np.array([v.std(ddof=1) / np.sqrt(len(v)) for v in found.values()])
        b, bar, reduced = growth(np.array(list(counts)), means, errors)
        cells = " | ".join(_bar(v) for v in found.values())
        print(f"| {delta:g} | {cells} | {b:.1f} ± {bar:.1f} | {reduced:.1f} |", flush=True)


def growth(
    counts: np.ndarray, means: np.ndarray, errors: np.ndarray
) -> tuple[float, float, float]:
    """(b, its standard error, χ² per degree of freedom) of the fit a (1 + b/N).

    With slope s = a b, var b = b² (var s/s² + var a/a² - 2 cov(s, a)/(s a)), times χ² per degree
    of freedom where it exceeds 1.
    """
    (s, a), C = np.polyfit(1 / counts, means, 1, w=1 / errors, cov="unscaled")
    off = (means - a - s / counts) / errors
    reduced = float(off @ off) / (len(counts) - 2)
    relative = C[0, 0] / s**2 + C[1, 1] / a**2 - 2 * C[0, 1] / (s * a)
    return s / a, abs(s / a) * np.sqrt(relative * max(1.0, reduced)), reduced


def _loop_gains(delta: float, grains: int, seeds: Sequence[int]) -> np.ndarray:
    """K²/ℓ of gppsz, noise on diameters, per packing; beyond 100 grains by 24 probes."""
    values = []
    for p in make([Scene(grains, delta)] * len(seeds), seeds):
        network = net(p)
        error = error_map(network)
        K = (
            error.gain
            if grains <= 100
            else error.estimated_gain(np.random.default_rng(SEED), 24)[0]
        )
        values.append(K**2 / (network.faces / network.contacts))
    return np.array(values)


def cut() -> None:
    """A region with known boundary forces against the periodic packing it is cut from."""
    for d in (1e-2, 1e-4):
        p = full(d)
        f = p.forces.reshape(2, -1)
        mask = np.linalg.norm(p.positions - p.cell.sum(axis=0) / 2, axis=1) < p.cell[0, 0] / 2.2
        region = without_dangling(net(p), mask, f)
        equation = force_equation(region)
        K, bar = error_map(region).estimated_gain(np.random.default_rng(SEED), 12)
        ratio = K**2 / (region.faces / region.contacts)
        h = equation.hyperstaticity / equation.unknowns
        print(f"open region Δ={d:g}, {len(region.active)} grains, Z={region.coordination:.3f}: "
              f"gppsz K²/(l/c) = {ratio:.3f} ± {2 * bar * ratio / K:.3f} (standard error of 12 "
              f"probes, one packing), h/unknowns = {h:.3f}, "
              f"balanced K = {error_map(region, 'balanced').gain:.3f}")  # fmt: skip


def without_dangling(
    network: ContactNetwork, mask: np.ndarray, forces: np.ndarray
) -> ContactNetwork:
    """The grains of `mask` that keep two contacts, cut out with their loads."""
    while True:
        inner = network.pairs[mask[network.pairs].all(axis=1)]
        lonely = mask & (np.bincount(inner.ravel(), minlength=network.grains) < 2)
        if not lonely.any():
            return network.inside(mask, *forces)
        mask = mask & ~lonely


def positions() -> None:
    """K of the bound, noise 1 on diameters and ζ/ξ on positions, over that for ζ = ξ."""
    ratios = 10.0 ** np.arange(0, -8, -1)
    print("| Δ | Z | " + " | ".join(f"ζ/ξ = {r:g}" for r in ratios) + " |")
    print("|---|---|" + "---|" * len(ratios))
    for p in make([Scene(300, d) for d in (1e-1, 1e-2, 1e-3, 1e-4)], [0] * 4):
        d, n, cells = p.delta, net(p), []
        for r in ratios:
            L = np.concatenate([np.full(n.grains, 0.5), np.full(2 * n.grains, r)])
            bound = cramer_rao(n, covariance=L**2, forces=p.forces, stiffness=p.stiffness)
            K, _ = bound.estimated_gain(np.random.default_rng(SEED), 6)
            unit = np.sqrt(np.mean(L**2))  # the ξ of that covariance
            cells.append(f"{K * unit:.2e}")
        print(f"| {d:g} | {n.coordination:.3f} | " + " | ".join(cells) + " |", flush=True)


def ratio() -> None:
    """Balanced over gppsz, noise on diameters: exact, six packings each."""
    print(
        "| N | " + " | ".join(f"Δ = {d:g}" for d in (1e-1, 1e-2, 1e-4)) + " |\n|---|---|---|---|"
    )
    for n in (20, 40, 100, 300):
        cells = []
        for d in (1e-1, 1e-2, 1e-4):
            some = make([Scene(n, d)] * 6, range(6))
            r = np.array(
                [error_map(net(p), "balanced").gain / error_map(net(p)).gain for p in some]
            )
            cells.append(f"{r.mean():.2f} ({r.min():.2f}–{r.max():.2f})")
        print(f"| {n} | " + " | ".join(cells) + " |", flush=True)


def prior() -> None:
    """E of `bounded` for different priors: no geometry (ξ = ∞), ξ = Δ and 10 Δ on positions."""
    choices = {
        "mean f̄, sd f̄ and f̄/2": Prior(),
        "mean 0": Prior(mean=0.0),
        "sd halved": Prior(1.0, 0.5, 0.25),
        "sd doubled": Prior(1.0, 2.0, 1.0),
        "sd of f_t f̄/10": Prior(1.0, 1.0, 0.1),
        "flat (sd 100 f̄)": Prior(1.0, 100.0, 100.0),
    }
    print("| prior | Δ | ξ = 0.1 Δ | ξ = Δ | ξ = 10 Δ | ξ = ∞ |\n|---|---|---|---|---|---|")
    for name, choice in choices.items():
        for d in (1e-2, 1e-4):
            some = make([Scene(300, d)] * 3, range(3))
            cells = []
            for strength in (0.1, 1.0, 10.0, np.inf):
                if 0.05 < strength * d < np.inf:
                    cells.append("")
                    continue
                e = [_bounded_error(p, strength * d, choice) for p in some]
                cells.append(f"{np.mean(e):.3f} ± {np.std(e, ddof=1):.3f}")
            print(f"| {name} | {d:g} | " + " | ".join(cells) + " |", flush=True)


def _problem(p: Packing, xi: float, choice: Prior | None = None):  # type: ignore[no-untyped-def]
    n, noise = net(p), None
    if np.isfinite(xi):
        n = perturb(n, xi, np.random.default_rng(SEED), "position")
        noise = sources(n, "position", xi=xi)
    return posterior(
        n, p.stiffness, p.friction, noise, pressure=p.pressure, prior=choice,
        frictional=p.friction > 0,
    )  # fmt: skip


def _bounded_error(p: Packing, xi: float, choice: Prior) -> float:
    return relative_error(bounded_forces(_problem(p, xi, choice))[0], p.forces)


ONE, TWO, FOUR, EXACT = ("projected", 1.0), ("projected", 2.0), ("projected", 4.0), ("exact", 2.0)
COVERAGE = (
    # N, friction, Δ, packings, ways
    (48, 0.0, (1e-4,), 12, (ONE, TWO)),
    (100, 0.3, (1e-2, 1e-4), 6, (ONE, TWO, FOUR, EXACT)),
    (100, 0.1, (1e-3,), 3, (ONE, TWO)),
    (100, 1.0, (1e-3,), 3, (ONE, TWO)),
    (1000, 0.3, (1e-2, 1e-4), 2, (ONE, TWO, EXACT)),
)
STRENGTHS = (0.1, 1.0, 10.0, np.inf)


def measure_coverage() -> None:
    """Fraction of true forces inside the 90 % and 50 % intervals, 40 draws each, with the width of
    the former, E of the mean of the draws and, for comparison, of the maximum with spread 1.

    The spread 2 was chosen from 1, 2 and 4 on N = 100, μ = 0.3; the other groups test it.
    """
    print("| N | μ | Δ | ξ/Δ | draws, prior | 90 % | 50 % | width of the 90 % interval / f̄ |"
          " E of the mean | E of the maximum | scatter of f_n/f̄ in draws | true |")  # fmt: skip
    print("|---|---|---|---|---|---|---|---|---|---|---|---|")
    for n, mu, deltas, count, ways in COVERAGE:
        for d in deltas:
            if n < 1000:
                some = make([Scene(n, d, friction=mu)] * count, range(count))
            else:
                some = [full(d, k) for k in range(count)]
            for strength in STRENGTHS:
                if 0.05 < strength * d < np.inf:
                    continue
                for method, spread in ways:
                    v = np.array([_covered(p, strength * d, method, spread) for p in some])
                    cells = [f"{x.mean():.2f} ± {x.std(ddof=1):.2f}" for x in v[:, :2].T]
                    cells += [f"{x.mean():.3g} ± {x.std(ddof=1):.1g}" for x in v[:, 2:].T]
                    name = f"| {n} | {mu:g} | {d:g} | {strength:g} | {method}, {spread:g} × | "
                    print(name + " | ".join(cells) + " |", flush=True)


def _covered(p: Packing, xi: float, method: str, spread: float) -> tuple[float, ...]:
    """(share in the 90 % intervals, in the 50 % ones, width of the former, E of the mean, of the
    maximum, standard deviation over contacts of f_n/f̄ in the draws, of the true f_n/f̄)."""
    narrow = _problem(p, xi)
    problem, c = widened(narrow, spread), len(p.pairs)
    smooth = not problem.equation.frictional
    sampler = {"projected": posterior_draws, "exact": truncated_draws}[method]
    sample = sampler(problem, np.random.default_rng(SEED), 40)
    slack = 1e-6 * problem.mean_force
    (low, high), half = enclosing(sample, 0.9), enclosing(sample, 0.5)
    width = float(np.mean(high - low)) / problem.mean_force
    inside = coverage(low, high, p.forces, slack), coverage(*half, p.forces, slack)
    best = bounded_forces(narrow)[0]
    errors = [relative_error(f, p.forces, frictional=not smooth) for f in (sample.mean(0), best)]
    scatter = float(sample[:, :c].std(axis=1).mean()), float(p.normal_forces.std())
    return *inside, width, *errors, *(s / p.normal_forces.mean() for s in scatter)


STIFFNESS_AT = (1e-1, 1e-2, 1e-4)
ERROR = 0.1


def stiffness() -> None:
    """E of a wrong stiffness: by one factor, spread over contacts, in the contact law."""
    print(f"All for s = ε = {ERROR:g}; three packings of N = 300, or regions of them.\n")
    print("| Δ | estimator | factor, no loads | pressure used | factor, known loads | share f_L/f"
          " | spread | Hertz, pressure used |")  # fmt: skip
    print("|---|---|---|---|---|---|---|---|")
    for d in STIFFNESS_AT:
        some = make([Scene(300, d)] * 3, range(3))
        for method in ("gppsz", "balanced", "direct"):
            v = np.array([_wrong_stiffness(p, method) for p in some])
            cells = [f"{x.mean():.3f} ± {x.std(ddof=1):.3f}" for x in v.T]
            print(f"| {d:g} | {method} | " + " | ".join(cells) + " |", flush=True)
        for method in ("optimal", "bounded"):
            v = np.array([_weighed(p, method) for p in some])
            print(f"| {d:g} | {method} | {v.mean():.3f} ± {v.std(ddof=1):.3f} | | | | | |",
                  flush=True)  # fmt: skip


def _wrong_stiffness(p: Packing, method: str) -> tuple[float, ...]:
    n, κ, true = net(p), p.stiffness, p.forces
    δ = p.normal_forces / κ

    def error(overlaps: np.ndarray, factor: float = 1.0, scaled: bool = False) -> float:
        found = forces_of_overlaps(n, overlaps, factor * κ, method)
        return relative_error(to_pressure(n, found, p.pressure) if scaled else found, true)

    spread = δ / (1 + ERROR * np.random.default_rng(SEED).uniform(-1, 1, len(δ)) * np.sqrt(3))
    centre = p.cell.sum(axis=0) / 2
    mask = np.linalg.norm(p.positions - centre, axis=1) < p.cell[0, 0] / 2.2
    region = without_dangling(n, mask, true.reshape(2, -1))
    f = true.reshape(2, -1)[:, region.contact_index].ravel()
    own = f[: region.contacts] / κ
    with_loads = forces_of_overlaps(region, own, (1 + ERROR) * κ, method)
    loops = (with_loads - forces_of_overlaps(region, own, κ, method)) / ERROR
    return (
        error(δ, 1 + ERROR), error(δ, 1 + ERROR, True), relative_error(with_loads, f),
        float(np.linalg.norm(loops) / np.linalg.norm(f)), error(spread),
        error(δ ** (2 / 3), 1, True),
    )  # fmt: skip


def _weighed(p: Packing, method: str) -> float:
    """E of `optimal` or `bounded` for κ wrong by one factor, data exact but taken as ξ = 0.1 Δ."""
    more = {"friction": p.friction, "pressure": p.pressure} if method == "bounded" else {}
    κ, xi = (1 + ERROR) * p.stiffness, 0.1 * p.delta
    found = reconstruct(net(p), κ, method, xi=xi, noise="position", **more)
    return relative_error(found.forces, p.forces)


def times() -> None:
    """CPU seconds of a first solve (factorisation included), exponent from N = 900 on."""
    small = make([Scene(100, 1e-4)], [0])[0]
    cases: dict[str, tuple[int, Callable]] = {
        "gppsz, factor": (32, lambda n, p: reconstruct(n, 1.0, solver="factor")),
        "gppsz, lsmr 1e-8": (100, lambda n, p: reconstruct(n, 1.0, solver="lsmr", tol=1e-8)),
        "balanced": (32, lambda n, p: reconstruct(n, 1.0, "balanced")),
        "optimal, positions": (
            32, lambda n, p: reconstruct(n, 1.0, "optimal", xi=1e-5, noise="position")
        ),
        "bounded, positions": (
            10, lambda n, p: reconstruct(n, 1.0, "bounded", xi=1e-4, noise="position",
                                         friction=p.friction, pressure=p.pressure)
        ),
    }  # fmt: skip
    copies = (1, 3, 10, 32, 100)
    print("| method | " + " | ".join(f"N = {100 * k * k:.3g}" for k in copies) + " | exponent |")
    print("|---|" + "---|" * (len(copies) + 1))
    for name, (most, solve) in cases.items():
        seconds, sizes = [], []
        for k in copies:
            if k > most:
                continue
            noisy = perturb(tiled(net(small), k), 1e-5, np.random.default_rng(SEED), "position")
            force_equation(noisy)  # assembly is timed apart
            start = time.process_time()
            solve(noisy, small)
            seconds.append(time.process_time() - start)
            sizes.append(100 * k * k)
        slope = np.polyfit(np.log(sizes[1:]), np.log(seconds[1:]), 1)[0]
        cells = [f"{s:.2g} s" for s in seconds] + [""] * (len(copies) - len(seconds))
        print(f"| {name} | " + " | ".join(cells) + f" | {slope:.2f} |", flush=True)


STUDIES = {
    "laws": laws, "prefactor": prefactor, "size": size, "positions": positions, "ratio": ratio,
    "prior": prior, "coverage": measure_coverage, "stiffness": stiffness, "time": times,
}  # fmt: skip


def main() -> None:
    """The studies named, or all; ValueError for a name that is none."""
    if unknown := set(sys.argv[1:]) - set(STUDIES):
        raise ValueError(f"{unknown.pop()}: no such study; there are {', '.join(STUDIES)}")
    for name in sys.argv[1:] or STUDIES:
        start = time.perf_counter()
        print(f"\n## {name}\n")
        STUDIES[name]()
        print(f"\n({time.perf_counter() - start:.0f} s)", flush=True)


if __name__ == "__main__":
    main()
