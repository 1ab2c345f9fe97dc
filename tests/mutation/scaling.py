"""Mutations of the theory: geometry, balance and closure, noise, measures."""

from __future__ import annotations

from tests.mutation.mutation import Mutation

NOISE = ("tests/scaling/test_measurement_noise.py",)
GAIN = ("tests/scaling/test_error_propagation.py",)
NETWORK = ("tests/scaling/test_contact_network.py",)
EQUATION = ("tests/scaling/test_force_equation.py",)
LOOPS = ("tests/scaling/test_loops.py",)
STRESS = ("tests/scaling/test_stress_and_error.py",)

SCALING = (
    Mutation(
        "noise of diameters on radii",
        "scaling/noise.py",
        '{"diameter": mean / 2, "radius": mean,',
        '{"diameter": mean, "radius": mean,',
        NOISE,
    ),
    Mutation(
        "torques keep their radii",
        "scaling/noise.py",
        "    external[:, 2] *= radii / network.radii\n",
        "",
        NOISE,
    ),
    Mutation(
        "turned force: sign of f_t",
        "scaling/noise.py",
        "fn[:, None] * network.tangents + ft[:, None] * network.normals",
        "fn[:, None] * network.tangents - ft[:, None] * network.normals",
        NOISE,
    ),
    Mutation(
        "displacement along n: sign",
        "scaling/noise.py",
        "-network.mean_diameter * _incidence(network, -1.0)",
        "network.mean_diameter * _incidence(network, -1.0)",
        (*NOISE, *GAIN),
    ),
    Mutation(
        "stress: sign of f_t",
        "scaling/virial.py",
        "on_j = on_j - f[c:, None]",
        "on_j = on_j + f[c:, None]",
        STRESS,
    ),
    Mutation(
        "mean force: f_t left out",
        "scaling/error.py",
        "np.hypot(*f.reshape(2, -1)).mean()",
        "np.abs(f.reshape(2, -1)[0]).mean()",
        STRESS,
    ),
    Mutation(
        "error: mean instead of rms",
        "scaling/error.py",
        "np.sqrt(np.mean((p - f) ** 2))",
        "np.mean(np.abs(p - f))",
        STRESS,
    ),
    Mutation(
        "winding: sign of the shift",
        "scaling/windings.py",
        "network.images - (shift[j] - shift[i])",
        "network.images + (shift[j] - shift[i])",
        LOOPS,
    ),
    Mutation(
        "winding rank: > for >=",
        "scaling/windings.py",
        "(xx * yy - xy**2 > 0)",
        "(xx * yy - xy**2 >= 0)",
        LOOPS,
    ),
    Mutation(
        "winding loops: largest area for smallest",
        "scaling/windings.py",
        "np.unravel_index(np.argmin(area), area.shape)",
        "np.unravel_index(np.argmax(np.where(np.isinf(area), 0, area)), area.shape)",
        LOOPS,
    ),
    Mutation(
        "faces: outside counted too",
        "scaling/loops.py",
        "bounded = turning == 1\n",
        "bounded = turning >= -1\n",
        LOOPS,
    ),
    Mutation(
        "faces: direction of travel",
        "scaling/loops.py",
        "sign = np.repeat([1, -1], c)",
        "sign = np.repeat([1, 1], c)",
        LOOPS,
    ),
    Mutation(
        "tangent turned by -90°",
        "scaling/network.py",
        "[-self.normals[:, 1], self.normals[:, 0]]",
        "[self.normals[:, 1], -self.normals[:, 0]]",
        NETWORK,
    ),
    Mutation(
        "mean diameter is a radius",
        "scaling/network.py",
        "return 2 * float(self.radii.mean())",
        "return float(self.radii.mean())",
        (*NOISE, *NETWORK),
    ),
    Mutation(
        "nearest image: one neighbour too few",
        "scaling/network.py",
        "[[a, b] for a in (-1, 0, 1) for b in (-1, 0, 1)]",
        "[[a, b] for a in (0,) for b in (0,)]",
        NETWORK,
    ),
    Mutation(
        "torque: opposite on the second grain",
        "scaling/equation.py",
        "total = csr_array((np.ones(2 * c), (grain, contact)), shape=shape)",
        "total = csr_array((np.repeat([1.0, -1.0], c), (grain, contact)), shape=shape)",
        EQUATION,
    ),
    Mutation(
        "loads: torque not over R",
        "scaling/equation.py",
        "columns.append(-F[:, 2] / self.network.radii[active])",
        "columns.append(-F[:, 2])",
        EQUATION,
    ),
    Mutation(
        "closure: lattice vector left out",
        "scaling/equation.py",
        "stiffness * (self.Q @ self.network.sigma - Λ)",
        "stiffness * (self.Q @ self.network.sigma)",
        EQUATION,
    ),
    Mutation(
        "hyperstaticity: moment of an open component",
        "scaling/equation.py",
        "np.where(rank == 0, 3, 2)",
        "np.where(rank == 0, 2, 2)",
        EQUATION,
    ),
    Mutation(
        "cut: load on the second grain",
        "scaling/subnetwork.py",
        "((0, 1), (1, -1)):",
        "((0, 1), (1, 1)):",
        NETWORK,
    ),
    Mutation(
        "cut: torque without R",
        "scaling/subnetwork.py",
        "network.radii[grain] * ft[cut]",
        "ft[cut]",
        NETWORK,
    ),
    Mutation(
        "tiling: copies side by side in the wrong order",
        "scaling/tiling.py",
        "((inside[..., 0] * n + inside[..., 1]) * N + j)",
        "((inside[..., 1] * n + inside[..., 0]) * N + j)",
        ("tests/scaling/test_tiling.py",),
    ),
    Mutation(
        "overlap noise of positions: sign",
        "scaling/sources.py",
        "B = B - distance_response(network)",
        "B = B + distance_response(network)",
        ("tests/scaling/test_error_theory.py",),
    ),
    Mutation(
        "prefactor floor: factor 2",
        "scaling/prefactor.py",
        "floor=float(np.sum(τ**2)) / 2 / n",
        "floor=float(np.sum(τ**2)) / n",
        ("tests/scaling/test_prefactor.py",),
    ),
    Mutation(
        "list error: missed contacts left out",
        "scaling/detection.py",
        " + np.sum(np.delete(true, t, axis=1) ** 2)",
        "",
        ("tests/scaling/test_detection.py",),
    ),
    Mutation(
        "stiffness response: sign",
        "scaling/calibration.py",
        "np.concatenate([np.zeros(equation.M.shape[0]), -off])",
        "np.concatenate([np.zeros(equation.M.shape[0]), off])",
        ("tests/scaling/test_calibration.py",),
    ),
    Mutation(
        "own image: one of the two left out",
        "scaling/lattice.py",
        "(images[:, 0] > 0) | ((images[:, 0] == 0) & (images[:, 1] > 0))",
        "images[:, 0] > 0",
        ("tests/scaling/test_detection.py", "tests/scaling/test_tiling.py"),
    ),
)
