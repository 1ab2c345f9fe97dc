"""What sizes and exact directions leave open: the mean stress.

Of the closure rows wᵀQ those with wᵀQ B = 0 feel no error of a size, B the response of σ. Read w
as a potential on the faces. It jumps by Δw_e across contact e, the row is h_e = Δw_e · n_e, and
the jump turned by 90° is a force on every contact, F_e = h_e t_e - (Δw_e · t_e) n_e. Around a
grain jumps add up to 0: forces balance. wᵀQ B = 0 says Σ h_e = 0 at every grain: torques balance.
And w is one-valued on the torus: no force crosses the cell. Hence

    { wᵀQ : wᵀQ B = 0 }  =  { f_t : M|f⟩ = 0 , mean stress 0 } .

For Z < 4 balance leaves h = 2c - 3N + 2 dimensions open. Of these the right-hand side, which is
exactly known, has h - 4: the mean stress Σ r n (f_n n - f_t t) has four components. So four modes
stay open, and the four components of the stress close them. The antisymmetric one is a matter of
lever arms, Σ r f_t = -Σ δ f_t by torque balance: 0 for touching grains, O(Δ) for others.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from scipy.linalg import null_space, qr, svdvals
from scipy.sparse import csr_array, vstack

from dem import Packing, Scene
from packing.arguments.arrays import Floats
from scaling import ContactNetwork, force_equation, perturb, relative_error
from scaling.algebra.equality_least_squares import ConstrainedLeastSquares
from scaling.estimators.bounded.maximum import bounded_forces
from scaling.estimators.bounded.posterior import posterior
from scaling.estimators.bounded.prior import Prior
from scaling.estimators.optimal.least_noise import size_problem
from scaling.noise.noise_model import noise_model
from scaling.uncertainty.relative_error import mean_force
from studies.error_bars import bar
from studies.packing_store import SEED, make, net

GROUPS = [(100, 0.3, 1e-2, 8), (100, 0.3, 1e-3, 8), (100, 0.3, 1e-4, 8), (300, 0.3, 1e-4, 6),
          (100, 0.1, 1e-4, 8), (100, 1.0, 1e-4, 8)]  # fmt: skip
"""N, μ, Δ and the number of packings, from seed 500."""
_RANK = 1e-10
"""Singular values below this are 0. The others are above 1e-7 down to Δ = 1e-4."""


def branch_rows(network: ContactNetwork, branches: Floats) -> Floats:
    """(4, 2c) unit rows: xx + yy, xx - yy, xy + yx, xy - yx of Σ branch (f_n n - f_t t)."""
    n, t, b = network.normals, network.tangents, branches
    σ = [[np.concatenate([b[:, i] * n[:, k], -b[:, i] * t[:, k]]) for k in (0, 1)]
         for i in (0, 1)]  # fmt: skip
    rows = np.array([σ[0][0] + σ[1][1], σ[0][0] - σ[1][1], σ[0][1] + σ[1][0], σ[0][1] - σ[1][0]])
    return rows / np.linalg.norm(rows, axis=1)[:, None]


def stress_rows(network: ContactNetwork) -> Floats:
    """(4, 2c): p, the two deviators and the antisymmetric component of the mean stress."""
    return branch_rows(network, network.distances[:, None] * network.normals)


def uncrossed_rows(network: ContactNetwork) -> Floats:
    """(4, 2c): wrong ones, with x_j - x_i as if no contact crossed a side of the cell.

    For forces that balance Σ (x_j - x_i) F is Σ x_i (Σ F)_i = 0: they say nothing.
    """
    x, (i, j) = network.positions, network.pairs.T
    assert x is not None
    return branch_rows(network, x[j] - x[i])


def self_stress(network: ContactNetwork) -> Floats:
    """(2c, h) orthonormal: null M."""
    return null_space(force_equation(network).M.toarray(), rcond=_RANK)


def noise_free_closure(network: ContactNetwork) -> Floats:
    """(k, c) orthonormal: the closure rows that no error of a size enters."""
    Q = force_equation(network).Q.toarray()
    B = noise_model(network, "diameter").overlaps(network).toarray()
    return _span(null_space((Q @ B).T, rcond=_RANK).T @ Q)


def unstressed_tangential(network: ContactNetwork, Z: Floats) -> Floats:
    """(k, c) orthonormal: f_t of the states of self-stress Z a that have no mean stress."""
    # The antisymmetric row is O(Δ) on them: made orthogonal to the others, and of length 1.
    a = null_space(_within(stress_rows(network), Z)[0], rcond=1e-6)
    return _span((Z @ a)[network.contacts :].T)


def open_modes(closure: Floats, rows: Floats, Z: Floats) -> int:
    """Dimensions that balance, the closure rows (k, c) and further rows (l, 2c) leave open."""
    c = closure.shape[1]
    s = svdvals(np.vstack([closure @ Z[:c], rows @ Z]))
    return Z.shape[1] - int((s > _RANK).sum())


def _within(rows: Floats, Z: Floats) -> tuple[Floats, Floats]:
    """(rows on null M made orthonormal one after the other, the lengths that they had)."""
    q, r = qr((rows @ Z).T, mode="economic")
    return q.T, abs(np.diag(r))


def _span(rows: Floats) -> Floats:
    _, s, Vt = np.linalg.svd(rows, full_matrices=False)
    return Vt[s > _RANK * float(s[0])]


def optimal_map(network: ContactNetwork, rows: Floats) -> Floats:
    """(2c, N) error map of `optimal`, data="sizes", told the true values of `rows` (k, 2c)."""
    equation, noise = force_equation(network), noise_model(network, "diameter")
    problem, k = size_problem(equation, noise), noise.count
    known = csr_array(np.hstack([np.zeros((len(rows), k)), rows]))
    b = np.zeros((problem.B.shape[0] + len(rows), k))
    M = equation.M.shape[0]
    b[M : problem.B.shape[0]] = (equation.Q @ noise.overlaps(network)).toarray()
    told = ConstrainedLeastSquares(
        problem.A, csr_array(vstack([problem.B, known])), "optimal estimate with the mean stress"
    )
    return told.solve(np.zeros((k, k)), b)[k:]


def gppsz_map(network: ContactNetwork, rows: Floats) -> Floats:
    """(2c, N) error map of gppsz, with the true values of `rows` (k, 2c) known."""
    equation = force_equation(network)
    G = equation.G.toarray()
    QB = equation.Q @ noise_model(network, "diameter").overlaps(network)
    b = np.vstack([np.zeros((equation.M.shape[0], network.grains)), QB.toarray()])
    free = null_space(rows) if len(rows) else np.eye(G.shape[1])
    return free @ np.linalg.lstsq(G @ free, b, rcond=None)[0]


def prefactor_of(p: Packing, error: Floats) -> float:
    """C of an error map."""
    K = np.linalg.norm(error) / np.sqrt(len(error))
    return float(K * p.pressure / mean_force(p.forces))


BOUNDED = {
    "bounded": (None, Prior()),
    "flat prior": (None, Prior(1.0, 100.0, 100.0)),
    "flat prior, μ = ∞": (1e9, Prior(1.0, 100.0, 100.0)),
}
"""Friction told (the true one if None) and prior; the pressure is told in all."""


def bounded_error(p: Packing, told: float | None, prior: Prior, draws: int = 4) -> float:
    """E of `bounded` at ξ = Δ, noise on diameters, data="sizes": rms over draws."""
    squares = []
    for k in range(draws):
        noisy = perturb(net(p), p.delta, np.random.default_rng([SEED, k]), "diameter")
        noise = noise_model(noisy, "diameter", xi=p.delta)
        friction = p.friction if told is None else told
        problem = posterior(noisy, p.stiffness, friction, noise, data="sizes",
                            pressure=p.pressure, prior=prior)  # fmt: skip
        squares.append(relative_error(bounded_forces(problem)[0], p.forces) ** 2)
    return float(np.sqrt(np.mean(squares)))


def measured(p: Packing) -> tuple[list[int], list[float]]:
    """Open modes with none, one ... four components, and with the wrong ones; then C of `optimal`
    with none to three, with three contact forces instead, of gppsz without and with p, the fourth
    singular value of the map, and the length of the antisymmetric row on null M."""
    n = net(p)
    Z, closure, rows = self_stress(n), noise_free_closure(n), stress_rows(n)
    ranks = [open_modes(closure, rows[:k], Z) for k in range(5)]
    ranks.append(open_modes(closure, uncrossed_rows(n), Z))
    maps = [optimal_map(n, rows[:k]) for k in range(4)]
    some = np.random.default_rng(SEED).choice(n.contacts, 3, replace=False)
    forces = np.eye(2 * n.contacts)[some]
    numbers = [prefactor_of(p, e) for e in (*maps, optimal_map(n, forces))]
    numbers += [prefactor_of(p, gppsz_map(n, rows[:k])) for k in (0, 1)]
    return ranks, [*numbers, float(svdvals(maps[0])[3]), float(_within(rows, Z)[1][3])]


def lines(groups: Sequence[tuple[int, float, float, int]] = GROUPS) -> Iterator[str]:
    """Open modes by rank, and E at ξ = Δ, which is C; ± standard errors over packings."""
    columns = ["N", "μ", "Δ", "Z", "modes open: none, 1, 2, 3, 4 given, wrong rows", "optimal",
               "p", "p, σxx - σyy", "all three", "three f_n", "gppsz", "with p",
               "4th singular value", "antisymmetric"]  # fmt: skip
    yield f"| {' | '.join(columns)} |\n|" + "---|" * len(columns)
    for grains, mu, delta, count in groups:
        packings = make([Scene(grains, delta, friction=mu)] * count, range(500, 500 + count))
        found = [measured(p) for p in packings]
        ranks = sorted({" ".join(map(str, r)) for r, _ in found})
        values = np.array([v for _, v in found])
        errors = values.std(axis=0, ddof=1) / np.sqrt(count)
        cells = [f"{m:.4f} ± {e:.4f}" if m > 0.01 else f"{m:.1e} ± {e:.0e}"
                 for m, e in zip(values.mean(axis=0), errors, strict=True)]  # fmt: skip
        Z = bar(np.array([net(p).coordination for p in packings]))
        yield (
            f"| {grains} | {mu:g} | {delta:g} | {Z} | {'; '.join(ranks)} | {' | '.join(cells)} |"
        )
    yield from told(groups[:4])


def told(groups: Sequence[tuple[int, float, float, int]]) -> Iterator[str]:
    """What `bounded`, which is told p, has beyond it: E at ξ = Δ."""
    yield f"\n| N | μ | Δ | optimal, told p | {' | '.join(BOUNDED)} |\n|" + "---|" * 7
    for grains, mu, delta, count in groups:
        packings = make([Scene(grains, delta, friction=mu)] * count, range(500, 500 + count))
        values = np.array([
            [prefactor_of(p, optimal_map(net(p), stress_rows(net(p))[:1])),
             *(bounded_error(p, *choice) for choice in BOUNDED.values())] for p in packings
        ])  # fmt: skip
        errors = values.std(axis=0, ddof=1) / np.sqrt(count)
        cells = [f"{m:.4f} ± {e:.4f}" for m, e in zip(values.mean(axis=0), errors, strict=True)]
        yield f"| {grains} | {mu:g} | {delta:g} | {' | '.join(cells)} |"
