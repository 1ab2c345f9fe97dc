"""Studies of the estimators behind docs/estimators.md, one table each.

    python benchmarks/estimators.py [laws] [positions] [ratio] [prior] [coverage] [time]

laws       gains against loops per contact and hyperstaticity per unknown, over friction and N
positions  how fast redundant radii are lost: the bound for noise ξ on diameters, ζ on positions
ratio      balanced over gppsz over N and Δ
prior      what the prior of `bounded` does
coverage   of the credible intervals
time       per solve against N, with the exponent

Packings come from the store of the figures; missing ones are made (a minute with Numba).
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Sequence

import numpy as np

from dem import Packing, Scene, Settings, relax_ensemble
from paper_figs import fig5
from paper_figs.packings import DELTAS, FULL, ROOT, one, seed_of
from scaling import (
    ContactNetwork,
    cramer_rao,
    error_map,
    force_equation,
    perturb,
    reconstruct,
    relative_error,
    tiled,
)
from scaling.bounded import Prior, bounded_forces, posterior
from scaling.credible import coverage, enclosing, posterior_draws, widened
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
          " gppsz/bound (positions) |")  # fmt: skip
    print("|---|---|---|---|---|---|---|---|")
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
              f"gppsz K²/(l/c) = {ratio:.3f} ± {2 * bar * ratio / K:.3f}, h/unknowns = {h:.3f}, "
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
    """Balanced over gppsz, noise on diameters: exact, three packings each."""
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
    n = net(p)
    if np.isinf(xi):
        return posterior(n, p.stiffness, p.friction, None, pressure=p.pressure, prior=choice)
    noisy = perturb(n, xi, np.random.default_rng(SEED), "position")
    noise = sources(noisy, "position", xi=xi)
    return posterior(noisy, p.stiffness, p.friction, noise, pressure=p.pressure, prior=choice)


def _bounded_error(p: Packing, xi: float, choice: Prior) -> float:
    return relative_error(bounded_forces(_problem(p, xi, choice))[0], p.forces)


COVERAGE = (
    # N, friction, Δ, packings, ways
    (100, 0.3, (1e-2, 1e-4), 3, (("projected", 1.0), ("projected", 2.0), ("exact", 2.0))),
    (100, 0.1, (1e-3,), 3, (("projected", 1.0), ("projected", 2.0))),
    (100, 1.0, (1e-3,), 3, (("projected", 1.0), ("projected", 2.0))),
    (1000, 0.3, (1e-2, 1e-4), 2, (("projected", 1.0), ("projected", 2.0))),
)


def measure_coverage() -> None:
    """Fraction of true forces inside the 90 % and 50 % intervals, 40 draws each.

    The spread 2 was chosen on N = 100, μ = 0.3 (seeds 0 to 5); the other groups test it.
    """
    print("| N | μ | Δ | ξ/Δ | draws, prior | 90 % | 50 % | width of the 90 % interval / f̄ |")
    print("|---|---|---|---|---|---|---|---|")
    for n, mu, deltas, count, ways in COVERAGE:
        for d in deltas:
            some = [full(d, k) for k in range(count)]
            if n < 1000:
                some = make([Scene(n, d, friction=mu)] * count, range(count))
            for strength in (0.1, 1.0, 10.0, np.inf):
                if 0.05 < strength * d < np.inf:
                    continue
                for method, spread in ways:
                    v = np.array([_covered(p, strength * d, method, spread) for p in some])
                    a, b = (f"{x.mean():.2f} ± {x.std(ddof=1):.2f}" for x in v[:, :2].T)
                    print(f"| {n} | {mu:g} | {d:g} | {strength:g} | {method}, {spread:g} × | "
                          f"{a} | {b} | {v[:, 2].mean():.3f} |", flush=True)  # fmt: skip


def _covered(p: Packing, xi: float, method: str, spread: float) -> tuple[float, float, float]:
    """(share in the 90 % intervals, in the 50 % ones, width of the former) of one packing."""
    problem = widened(_problem(p, xi), spread)
    sampler = {"projected": posterior_draws, "exact": truncated_draws}[method]
    sample = sampler(problem, np.random.default_rng(SEED), 40)
    slack = 1e-6 * problem.mean_force
    (low, high), half = enclosing(sample, 0.9), enclosing(sample, 0.5)
    width = float(np.mean(high - low)) / problem.mean_force
    return coverage(low, high, p.forces, slack), coverage(*half, p.forces, slack), width


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
    "laws": laws, "positions": positions, "ratio": ratio, "prior": prior,
    "coverage": measure_coverage, "time": times,
}  # fmt: skip


def main() -> None:
    """The studies named, or all."""
    for name in sys.argv[1:] or STUDIES:
        start = time.perf_counter()
        print(f"\n## {name}\n")
        STUDIES[name]()
        print(f"\n({time.perf_counter() - start:.0f} s)", flush=True)


if __name__ == "__main__":
    main()
