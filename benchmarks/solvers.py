"""Solvers of Eq. 1: time and memory against error, over N.

A periodic packing of 100 grains is tiled n × n; the right-hand side is G f for forces f that are
the tiled ones times 1 + 0.3 × noise (else an iteration would see one tile only), so that the
error is the solver's alone.  Time: processor seconds, matrix given, forces wanted; the median of a
few where one is short.  Memory: growth of the resident set.  Every solve is repeated in three
processes of its own, the solvers in turns; medians (min–max) over these.  GPPSZ write the dense
normal equations.
"""

from __future__ import annotations

import multiprocessing
import resource
import time
from collections.abc import Callable
from typing import Any

import numpy as np
from scipy.linalg import cho_factor, cho_solve, qr, solve_triangular, svd
from scipy.sparse import bmat, csc_array, eye_array
from scipy.sparse.linalg import lsmr, splu

from dem import Packing
from scaling import ContactNetwork, force_equation, relative_error, tiled, tiled_forces
from scaling.algebra.least_squares import LeastSquares
from studies.error_bars import exponent, spread

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
    "SVD": (svd_dense, 900),
    "QR": (qr_dense, 1_600),
    "normal sparse": (normal_sparse, 3_600),
    "augmented": (augmented, 10_000),
    "factor": (factor, 110_000),
    **{f"lsmr {t:.0e}": (iterate(t), 1_000_000) for t in (1e-4, 1e-6, 1e-8, 1e-12)},
}
TABLE = np.dtype([
    ("solver", "U16"), ("repeat", int), ("grains", int), ("unknowns", int), ("seconds", float),
    ("MB", float), ("error", float),
])  # fmt: skip
REPEATS = 3
#: Processor seconds within which a solve is repeated in one process.
PATIENCE = 0.3
#: Less memory is hidden in what the process already holds (MB).
SEEN = 5.0
#: Exponents are fitted over so many of the largest sizes.
FITTED = 4


def _resident() -> float:
    with open("/proc/self/statm") as statm:
        return int(statm.read().split()[1]) * resource.getpagesize() / 1e6


def measure(task: tuple[str, int, Packing, int]) -> tuple[Any, ...]:
    """One solve in a fresh process."""
    name, repeat, packing, n = task
    one = ContactNetwork.from_packing(packing)
    network, true = tiled(one, n), tiled_forces(one, packing.forces, n)
    G = force_equation(network).G
    true = true * (1 + 0.3 * np.random.default_rng(n).standard_normal(len(true)))
    b = G @ true
    before, times, peak = _resident(), [], 0.0
    while not times or sum(times) < PATIENCE:
        start = time.process_time()
        found = SOLVERS[name][0](G, b)
        times.append(time.process_time() - start)
        peak = peak or resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e3
    error = relative_error(found, true, frictional=True)
    seconds, MB = float(np.median(times)), max(peak - before, 0.0)
    return name, repeat, network.grains, G.shape[1], seconds, MB, error


def compute(packing: Packing, copies: tuple[int, ...], repeats: int = REPEATS) -> np.ndarray:
    """All solvers at all sizes they can do."""
    tasks = [
        (name, repeat, packing, n)
        for n in copies
        for repeat in range(repeats)
        for name, (_, most) in SOLVERS.items()
        if n * n * len(packing.radii) <= most
    ]
    context = multiprocessing.get_context("fork")
    with context.Pool(1, maxtasksperchild=1) as pool:
        return np.array(pool.map(measure, tasks, chunksize=1), TABLE)


def by_size(table: np.ndarray, name: str) -> list[np.ndarray]:
    """The repeats of one solver at each size."""
    mine = table[table["solver"] == name]
    return [mine[mine["grains"] == n] for n in np.unique(mine["grains"])]


def exponents(table: np.ndarray, column: str) -> dict[str, tuple[float, float, int]]:
    """a in seconds (or MB) ~ N^a, its error and the sizes used: the largest ones of each solver,
    where they can be told from nothing."""
    found = {}
    for name in dict.fromkeys(table["solver"].tolist()):
        some = by_size(table, name)
        some = [r for r in some if r[column].min() > (SEEN if column == "MB" else 0)][-FITTED:]
        if len(some) > 1:
            fit = exponent([r["grains"][0] for r in some], [r[column] for r in some])
            found[name] = *fit, len(some)
    return found


def _exponent(fit: tuple[float, float, int] | None) -> str:
    return "not seen" if fit is None else f"{fit[0]:.2f} ± {fit[1]:.2f} ({fit[2]} sizes)"


def text(table: np.ndarray) -> str:
    """One line per solver and size, then the exponents."""
    lines = [f"Median (min–max) of {REPEATS} processes; largest E.", "",
             "| solver | N | s | MB | E |", "|---|---|---|---|---|"]  # fmt: skip
    for n in np.unique(table["grains"]):
        for name in dict.fromkeys(table["solver"].tolist()):
            r = table[(table["solver"] == name) & (table["grains"] == n)]
            if len(r):
                lines.append(f"| {name} | {n} | {spread(r['seconds'])} | {spread(r['MB'], '.0f')} "
                             f"| {r['error'].max():.0e} |")  # fmt: skip
    lines += ["", "| solver | time ~ N^ | memory ~ N^ |", "|---|---|---|"]
    time_of, memory_of = exponents(table, "seconds"), exponents(table, "MB")
    for name in time_of:
        cells = [_exponent(fits.get(name)) for fits in (time_of, memory_of)]
        lines.append(f"| {name} | {cells[0]} | {cells[1]} |")
    return "\n".join(lines)
