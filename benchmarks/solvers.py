"""Solvers of Eq. 1: time and memory against error, over N.

A periodic packing of 100 grains is tiled n × n; the right-hand side is G f for forces f that are
the tiled ones times 1 + 0.3 × noise (else an iteration would see one tile only), so that the
error is the solver's alone.  Time: processor seconds, matrix given, forces wanted; the best of a
few where one is short.  Memory: growth of the resident set in a process of its own.  GPPSZ write
the dense normal equations.
"""

from __future__ import annotations

import multiprocessing
import resource
import time
from collections.abc import Callable
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from scipy.linalg import cho_factor, cho_solve, qr, solve_triangular, svd
from scipy.sparse import bmat, csc_array, eye_array
from scipy.sparse.linalg import lsmr, splu

from benchmarks.tiling import tiled
from dem import Packing
from paper_figs.style import MARKERS, plt
from scaling import force_equation, relative_error
from scaling.algebra.least_squares import LeastSquares

Solver = Callable[[Any, np.ndarray], np.ndarray]


def normal_dense(G: Any, b: np.ndarray) -> np.ndarray:
    """(GᵀG)⁻¹Gᵀ b by Cholesky: the formula of GPPSZ."""
    A = G.toarray()
    return cho_solve(cho_factor(A.T @ A), A.T @ b)


def svd_dense(G: Any, b: np.ndarray) -> np.ndarray:
    """Singular values: the slowest, and tells the rank."""
    U, s, Vt = svd(G.toarray(), full_matrices=False)
    return Vt.T @ ((U.T @ b) / s)


def qr_dense(G: Any, b: np.ndarray) -> np.ndarray:
    """Householder QR."""
    Q, R = qr(G.toarray(), mode="economic")
    return solve_triangular(R, Q.T @ b)


def normal_sparse(G: Any, b: np.ndarray) -> np.ndarray:
    """Sparse LU of GᵀG, no refinement."""
    return splu(csc_array(G.T @ G), permc_spec="MMD_AT_PLUS_A").solve(G.T @ b)


def augmented(G: Any, b: np.ndarray) -> np.ndarray:
    """Sparse LU of [[1, G], [Gᵀ, 0]]: cond(G), not its square."""
    m, n = G.shape
    K = csc_array(bmat([[eye_array(m), G], [G.T, None]]))
    return splu(K).solve(np.concatenate([b, np.zeros(n)]))[m:]


def factor(G: Any, b: np.ndarray) -> np.ndarray:
    """What `reconstruct` takes: sparse LU of GᵀG, rank check and refinement."""
    return LeastSquares(G, "Eq. 1").solve(b, "factor")


def iterate(tolerance: float) -> Solver:
    """Lsmr to a relative tolerance."""

    def lsmr_to(G: Any, b: np.ndarray) -> np.ndarray:
        return lsmr(G, b, atol=tolerance, btol=tolerance, conlim=0, maxiter=5000)[0]

    return lsmr_to


#: Name, solver, most grains.
SOLVERS: dict[str, tuple[Solver, int]] = {
    "normal dense": (normal_dense, 1_600),
    "SVD": (svd_dense, 400),
    "QR": (qr_dense, 900),
    "normal sparse": (normal_sparse, 1_600),
    "augmented": (augmented, 10_000),
    "factor": (factor, 110_000),
    **{f"lsmr {t:.0e}": (iterate(t), 1_000_000) for t in (1e-4, 1e-6, 1e-8, 1e-12)},
}
TABLE = np.dtype([
    ("solver", "U16"), ("grains", int), ("unknowns", int), ("seconds", float), ("MB", float),
    ("error", float),
])  # fmt: skip
#: Processor seconds within which a solve is repeated.
PATIENCE = 0.3
#: Less memory is hidden in what the process already holds (MB).
SEEN = 5.0
#: Exponents are fitted over so many of the largest sizes.
FITTED = 4


def _resident() -> float:
    with open("/proc/self/statm") as statm:
        return int(statm.read().split()[1]) * resource.getpagesize() / 1e6


def measure(task: tuple[str, Packing, int]) -> tuple[Any, ...]:
    """One solve in a fresh process."""
    name, packing, n = task
    network, true = tiled(packing, n)
    G = force_equation(network).G
    true = true * (1 + 0.3 * np.random.default_rng(n).standard_normal(len(true)))
    b = G @ true
    before, times = _resident(), []
    while not times or sum(times) < PATIENCE:
        start = time.process_time()
        found = SOLVERS[name][0](G, b)
        times.append(time.process_time() - start)
    seconds = min(times)
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e3
    grains = network.grains
    error = relative_error(found, true, frictional=True)
    return name, grains, G.shape[1], seconds, max(peak - before, 0), error


def compute(packing: Packing, copies: tuple[int, ...]) -> np.ndarray:
    """All solvers at all sizes they can do."""
    tasks = [
        (name, packing, n)
        for n in copies
        for name, (_, most) in SOLVERS.items()
        if n * n * len(packing.radii) <= most
    ]
    context = multiprocessing.get_context("fork")
    with context.Pool(1, maxtasksperchild=1) as pool:
        return np.array(pool.map(measure, tasks, chunksize=1), TABLE)


def exponents(table: np.ndarray, column: str) -> dict[str, tuple[float, float, int]]:
    """Fitted a in seconds (or MB) ~ N^a, its standard error (NaN of two sizes) and the sizes used:
    the largest ones of each solver, where they can be told from nothing."""
    found = {}
    for name in dict.fromkeys(table["solver"]):
        mine = table[table["solver"] == name]
        mine = mine[mine[column] > (SEEN if column == "MB" else 0)]
        mine = mine[np.argsort(mine["grains"])][-FITTED:]
        x, y = np.log(mine["grains"]), np.log(mine[column])
        if len(mine) > 1:
            slope, shift = np.polyfit(x, y, 1)
            off = y - slope * x - shift
            spare = len(x) - 2
            error = np.sqrt(off @ off / spare / np.sum((x - x.mean()) ** 2)) if spare else np.nan
            found[str(name)] = float(slope), float(error), len(mine)
    return found


def _exponent(fit: tuple[float, float, int] | None) -> str:
    if fit is None:
        return "not seen"
    slope, error, sizes = fit
    return f"{slope:.1f} (two sizes)" if sizes == 2 else f"{slope:.2f} ± {error:.2f}"


def text(table: np.ndarray) -> str:
    """One line per solver and size, then the exponents."""
    lines = ["| solver | N | s | MB | E |", "|---|---|---|---|---|"]
    lines += [
        f"| {r['solver']} | {r['grains']} | {r['seconds']:.2g} | {r['MB']:.0f} "
        f"| {r['error']:.0e} |"
        for r in table
    ]
    lines += ["", "| solver | time ~ N^ | memory ~ N^ |", "|---|---|---|"]
    time_of, memory_of = exponents(table, "seconds"), exponents(table, "MB")
    for name in time_of:
        cells = [_exponent(fits.get(name)) for fits in (time_of, memory_of)]
        lines.append(f"| {name} | {cells[0]} | {cells[1]} |")
    return "\n".join(lines)


def plot(table: np.ndarray) -> Figure:
    """Time against N, memory against N, time against error at the largest common size."""
    figure, (a, b, c) = plt.subplots(1, 3, figsize=(7.2, 2.9), layout="constrained")
    names = list(dict.fromkeys(table["solver"]))
    common = max(n for n in np.unique(table["grains"]) if n <= 1000)
    for k, name in enumerate(names):
        mine = table[table["solver"] == name]
        # Direct methods in colours, lsmr in greys: the darker the more exact.
        tone = f"{0.22 * (len(SOLVERS) - 1 - k):.2f}" if name.startswith("lsmr") else f"C{k}"
        style = {"marker": MARKERS[k % len(MARKERS)], "label": name, "color": tone}
        a.plot(mine["grains"], mine["seconds"], **style)
        seen = mine[mine["MB"] > SEEN]
        b.plot(seen["grains"], seen["MB"], **style)
        at = mine[mine["grains"] == common]
        c.plot(at["error"], at["seconds"], linestyle="none", **style)
    a.set(xscale="log", yscale="log", xlabel="grains $N$", ylabel="seconds")
    b.set(xscale="log", yscale="log", xlabel="grains $N$", ylabel="memory (MB)", ylim=(1, None))
    c.set(xscale="log", yscale="log", xlabel=f"error $E$ ($N={common}$)", ylabel="seconds")
    figure.legend(*a.get_legend_handles_labels(), loc="outside lower center", ncol=5)
    return figure
