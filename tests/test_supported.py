"""Walls, weight and Hertz against all that can be asked: an answer that is right, or a refusal.

TABLE says for every question and every world "yes", or the words of the ValueError. Each cell is
run on a packing of 30 grains: what is answered is held against something else than itself, and so
is a control, an answer that is wrong. The table of `docs/howto/walls_and_weight.md` is this one.
"""

from __future__ import annotations

import re
from functools import cache
from typing import NamedTuple

import numpy as np
import pytest

from dem import Packing, Scene, Settings, packing_key, ramp, refine, relax, relax_ensemble, stiffen
from dem.model.confinement import Strip
from dem.protocols.ensembles.store import Store
from packing.contact_law import Hertz, law_between
from scaling import (
    ContactNetwork,
    collapse,
    cramer_rao,
    credible_intervals,
    error_map,
    flat_guess,
    force_equation,
    infer_contacts,
    perturb,
    reconstruct,
    relative_error,
    stress,
    tiled,
    tiled_forces,
    to_pressure,
    worst_pattern,
)
from scaling.estimators import Bounded
from scaling.estimators.table import ESTIMATORS
from tests.markdown import ROOT

EPS, DELTA, SEED = np.finfo(float).eps, 1e-3, 1
SETTINGS = Settings(backend="numpy")
WORLDS = {
    "strip": {"boundary": "walls"},
    "rough strip": {"boundary": Strip("rough")},
    "box": {"boundary": "box"},
    "weight": {"boundary": "walls", "gravity": 1e-4},
    "Hertz": {"contact": "hertz"},
    "all three": {"boundary": "box", "contact": "hertz", "gravity": 3e-6},
}
BETWEEN = "for periodic packings; this one stands between walls"
LINEAR = "takes linear laws only"
SPRINGS = "knows linear springs"


def row(walls: str = "yes", hertz: str = "yes") -> dict[str, str]:
    """A row of the table that tells walls and Hertz apart only; both meet the second first."""
    last = walls if hertz == "yes" else hertz
    return dict(zip(WORLDS, [walls] * 4 + [hertz, last], strict=True))


TABLE = {
    "ramp": row(BETWEEN, SPRINGS),
    "stiffen": row(BETWEEN, SPRINGS),
    "refine": row(BETWEEN, SPRINGS),
    "float32": row("knows no walls and no weight", "knows linear springs only"),
    "tiled": row("between walls cannot be tiled") | {"all three": "between walls cannot be tiled"},
    "inside": row(),
    "gppsz": row(),
    "direct": row(),
    "transverse": row(),
    "balanced": row(hertz=LINEAR),
    "optimal": row(hertz=LINEAR),
    "bounded": row(hertz=LINEAR),
    "credible_intervals": row(hertz=LINEAR),
    "error_map": row(),
    "worst_pattern": row(),
    "cramer_rao": row(),
    "collapse": row(),
    "flat_guess": row(),
    "to_pressure": row(),
    "infer_contacts": row(),
    "stress": row(),
    "npz": row(),
    "store": row(),
}
"""What is asked, by world: "yes", or the words of the refusal."""


def scene_of(world: str) -> Scene:
    return Scene(30, DELTA, **WORLDS[world])


@cache
def packing_of(world: str) -> Packing:
    return relax(scene_of(world), SEED, settings=SETTINGS, progress=False)


def network_of(p: Packing) -> ContactNetwork:
    return ContactNetwork.from_packing(p)


def exact(p: Packing) -> float:
    """Rounding of positions over Δ, times the condition of a small packing."""
    return 1e4 * EPS * np.sqrt(len(p.pairs)) / DELTA


def is_hertz(p: Packing) -> bool:
    return bool((p.provenance.scene or {}).get("contact") != "linear")


def law_of(p: Packing, n: ContactNetwork):
    """The law of the contacts of another network than that of `p`."""
    return law_between(Hertz(), n.radii, n.pairs) if is_hertz(p) else 1.0


def mean_pressure(p: Packing) -> float:
    return float(np.trace(stress(network_of(p), p.forces))) / 2


def told(p: Packing, method: str, xi: float = 1e-3 * DELTA, noise: str = "position") -> dict:
    """What a method asks for."""
    asked = {"normal_forces": p.normal_forces} if method == "transverse" else {}
    if method in ("optimal", "bounded"):
        asked = {"xi": xi, "noise": noise}
    if method == "bounded":
        asked |= {"friction": p.friction, "pressure": mean_pressure(p)}
    return asked


def linearised(p: Packing, noise: str) -> dict:
    """Where directions turn, or slopes change, the forces at which they do."""
    asked = noise == "position" or is_hertz(p)
    return {"forces": p.forces, "stiffness": p.law} if asked else {}


def slope(p: Packing) -> float:
    """κ of an error map: the mean slope of the contacts."""
    return float(np.mean(p.law.slope(p.overlaps)))


# --- questions: each raises ValueError, or shows that its answer is right -----------------


class Shown(NamedTuple):
    """How far an answer is off, how far a wrong one is, and what lies between."""

    error: float
    wrong: float
    bound: float


def at_rest(again: Packing, p: Packing) -> Shown:
    return Shown(again.residuals().max(), np.inf, 1e-9)


def ask_ramp(p: Packing, _: str) -> Shown:
    return at_rest(ramp(p, [2 * DELTA], settings=SETTINGS, progress=False)[0], p)


def ask_stiffen(p: Packing, _: str) -> Shown:
    return at_rest(stiffen(p, DELTA / 2), p)


def ask_refine(p: Packing, _: str) -> Shown:
    return at_rest(refine(p), p)


def ask_float32(p: Packing, world: str) -> Shown:
    single = Settings(backend="numpy", precision="float32")
    return at_rest(relax(scene_of(world), SEED, settings=single, progress=False), p)


def ask_tiled(p: Packing, _: str) -> Shown:
    n, f = tiled(network_of(p), 2), tiled_forces(network_of(p), p.forces, 2)
    found = reconstruct(n, law_of(p, n)).forces
    return Shown(relative_error(found, f), relative_error(found, np.roll(f, 1)), exact(p))


def ask_inside(p: Packing, _: str) -> Shown:
    """Half of the packing, the cut forces its loads. Wrong: sizes off by a hundredth of Δ."""
    n = network_of(p)
    low = n.positions[:, 1] < np.median(n.positions[:, 1])
    part = n.inside(low, p.normal_forces, p.tangential_forces)
    kept = part.contact_index
    f = np.concatenate([p.normal_forces[kept], p.tangential_forces[kept]])
    law, off = law_of(p, part), perturb(part, 0.01 * DELTA, np.random.default_rng(0))
    errors = [relative_error(reconstruct(at, law).forces, f) for at in (part, off)]
    return Shown(*errors, exact(p))


def ask_estimator(method: str, p: Packing) -> Shown:
    """Exact data give exact forces, but that the prior of `bounded` draws at them with (ξ/Δ)².
    Wrong: sizes off by a hundredth of Δ, or normal forces."""
    n, more = network_of(p), told(p, method)
    found = reconstruct(n, p.law, method, **more)
    if method == "transverse":
        more["normal_forces"] = more["normal_forces"] * (1 + 0.01 * np.cos(np.arange(n.contacts)))
    off = reconstruct(perturb(n, 0.01 * DELTA, np.random.default_rng(0)), p.law, method, **more)
    bound = exact(p) if method != "bounded" else 10 * (more["xi"] / DELTA) ** 2
    return Shown(relative_error(found, p), relative_error(off, p), bound)


def ask_credible_intervals(p: Packing, _: str) -> Shown:
    """Of 90 %, positions known to Δ/10. Wrong: those of another packing's forces."""
    xi, n = 0.1 * DELTA, network_of(p)
    equation = force_equation(perturb(n, xi, np.random.default_rng(0), "position"))
    estimator = Bounded(**told(p, "bounded", xi), progress=False)
    low, high = credible_intervals(
        estimator, equation.with_law(p.law), np.random.default_rng(1), draws=20
    )
    inside = [((low <= f) & (f <= high)).mean() for f in (p.forces, np.roll(p.forces, 1))]
    return Shown(*(abs(0.9 - share) for share in inside), 0.2)


def ask_error_map(p: Packing, _: str) -> Shown:
    """Against differences of the estimator for noise on sizes and on places. Wrong: the map of
    another estimator."""
    n, worst, wrong = network_of(p), 0.0, np.inf
    xi = 1e-4 * DELTA
    for noise in ("diameter", "position"):
        off = perturb(n, xi, np.random.default_rng(2), noise)
        moved = (off.positions - n.positions).T.ravel(), 2 * (off.radii - n.radii)
        η = moved[noise == "diameter"][:, None] / (xi * n.mean_diameter)
        found = reconstruct(off, p.law).forces - p.forces
        maps = [
            error_map(n, method, noise, **linearised(p, noise)) for method in ("gppsz", "direct")
        ]
        said = [slope(p) * xi * E.respond(η)[:, 0] for E in maps]
        errors = [np.abs(found - s).max() / np.abs(found).max() for s in said]
        worst, wrong = max(worst, errors[0]), min(wrong, errors[1])
    return Shown(worst, wrong, 0.01)


def ask_worst_pattern(p: Packing, _: str) -> Shown:
    """Sizes changed so change the forces by s. Wrong: another pattern of the same strength."""
    n, xi = network_of(p), 1e-4 * DELTA
    s, pattern, _ = worst_pattern(n, **linearised(p, "diameter"))
    errors = []
    for η in (pattern, np.roll(pattern, 1)):
        off = n.with_sizes(n.radii + 0.5 * xi * n.mean_diameter * η)
        change = np.linalg.norm(reconstruct(off, p.law).forces - p.forces)
        errors.append(abs(change / (slope(p) * xi * s) - 1))
    return Shown(*errors, 0.01)


def ask_cramer_rao(p: Packing, _: str) -> Shown:
    """Against J U (Uᵀ 𝓕 U)⁻¹ Uᵀ Jᵀ of positions and transverse forces, by differences. Wrong: the
    variance of `direct`."""
    n, c = network_of(p), len(p.pairs)
    M = force_equation(n).M

    def both(θ: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        at = n.replaced(positions=θ[: 2 * n.grains].reshape(-1, 2))
        f = np.concatenate([p.law.force(at.overlaps), p.tangential_forces + θ[2 * n.grains :]])
        return force_equation(at).M @ f, f

    start = np.concatenate([n.positions.ravel(), np.zeros(c)])
    h = np.concatenate([np.full(2 * n.grains, 1e-3 * DELTA), np.full(c, p.forces.max())])
    g, J = (np.empty((rows, len(start))) for rows in (M.shape[0], 2 * c))
    for k, step in enumerate(np.diag(h)):
        (g1, f1), (g0, f0) = both(start + step), both(start - step)
        g[:, k], J[:, k] = (g1 - g0) / (2 * h[k]), (f1 - f0) / (2 * h[k])
    _, s, V = np.linalg.svd(g / slope(p))
    U = V[int((s > 1e-9 * s[0]).sum()) :].T
    F = U[: 2 * n.grains].T @ U[: 2 * n.grains]
    deviations = np.sqrt(np.einsum("ij,jk,ik->i", J @ U, np.linalg.pinv(F), J @ U))
    maps = (
        cramer_rao(n, "position", **linearised(p, "position")),
        error_map(n, "direct", "position", **linearised(p, "position")),
    )
    said = [slope(p) / n.mean_diameter * E.per_component for E in maps]
    errors = [np.abs(deviations - each).max() / deviations.max() for each in said]
    return Shown(*errors, 0.01)


def ask_collapse(p: Packing, _: str) -> Shown:
    """The scatter of six draws against C. Wrong: against that of a Δ twice as large."""
    table = collapse([p], [0.01], np.random.default_rng(0), draws=6)
    E = np.sqrt(np.mean(table["error"] ** 2)) / 0.01
    return Shown(abs(E / table["C"][0] - 1), abs(E / (2 * table["C"][0]) - 1), 0.35)


def ask_flat_guess(p: Packing, _: str) -> Shown:
    """Told the mean pressure, its Σ f_n r is that of the packing. Wrong: 1 % more."""
    n, c, true = network_of(p), len(p.pairs), mean_pressure(p)
    sums = [flat_guess(n, q * true)[:c] @ n.distances for q in (1, 1.01)]
    errors = [abs(s / (p.normal_forces @ n.distances) - 1) for s in sums]
    return Shown(*errors, 100 * EPS)


def ask_to_pressure(p: Packing, _: str) -> Shown:
    found = [to_pressure(network_of(p), 3 * p.forces, q * mean_pressure(p)) for q in (1, 1.01)]
    return Shown(*(relative_error(f, p) for f in found), 100 * EPS)


def ask_infer_contacts(p: Packing, _: str) -> Shown:
    """The list that is on record. Wrong: only overlaps above the median."""
    listed = set(map(tuple, np.column_stack([p.pairs, p.images])))
    errors = []
    for h in (0.0, -float(np.median(p.overlaps))):
        found = infer_contacts(p.positions, p.radii, h, cell=p.cell, walls=p.walls)
        errors.append(len(set(map(tuple, np.column_stack(found))) ^ listed))
    return Shown(*errors, 0.5)


def ask_stress(p: Packing, _: str) -> Shown:
    """σ_yy A = Σ y f_y on walls, and glued grains, - Σ y F_y of the loads; of a periodic cell p.
    Wrong: the same with forces exchanged."""
    n, c, N = network_of(p), len(p.pairs), len(p.radii)
    if p.walls is None:
        values = [np.trace(stress(n, f)) / 2 for f in (p.forces, np.roll(p.forces, 1))]
        return Shown(*(abs(v / p.pressure - 1) for v in values), 1e-9)
    force = -n.tangents * p.tangential_forces[:, None] + n.normals * p.normal_forces[:, None]
    i, j = p.pairs.T
    at = n.positions[i] + n.distances[:, None] * n.normals
    onto = float(at[j >= N, 1] @ force[j >= N, 1])
    if p.walls.glued is not None:
        for end, sign in ((i, -1), (j, 1)):
            stuck = p.walls.glued[end] >= 0
            onto += sign * float(n.positions[end[stuck], 1] @ force[stuck, 1])
    onto -= float(n.positions[:, 1] @ n.external[:, 1])
    area = n.boundary.area
    assert area is not None
    values = [stress(n, f)[1, 1] * area for f in (p.forces, np.roll(p.forces, c // 2))]
    return Shown(*(abs(v / onto - 1) for v in values), 1e-9)


def lost(again: Packing, p: Packing) -> Shown:
    """Every number comes back. Wrong: one rounding of the forces."""
    assert again.provenance.scene == p.provenance.scene
    assert (again.walls is None) == (p.walls is None)
    assert p.walls is None or np.array_equal(again.walls.offsets, p.walls.offsets)
    rounding = np.abs(p.forces * (1 + EPS) - p.forces).max()
    differences = [np.abs(a - b).max() for a, b in ((again.forces, p.forces),
                   (again.law.force(p.overlaps), p.law.force(p.overlaps)))]  # fmt: skip
    return Shown(max(differences), rounding, rounding / 2)


def ask_npz(p: Packing, _: str, folder) -> Shown:
    p.save(folder / "p.npz")
    return lost(Packing.load(folder / "p.npz"), p)


def ask_store(p: Packing, world: str, folder) -> Shown:
    """What is there is not made again: here a packing of another seed lies under the key."""
    scene = scene_of(world)
    Store(folder).put(packing_key(scene, SEED, SETTINGS), p)
    kept = (folder / f"{packing_key(scene, SEED, SETTINGS)}.npz").stat().st_mtime_ns
    found = relax_ensemble([scene], [SEED], store=folder, settings=SETTINGS, progress=False)
    assert [f.stat().st_mtime_ns for f in folder.glob("*.npz")] == [kept]
    return lost(next(iter(found)), p)


def answer(question: str, world: str, folder) -> Shown:
    """What is shown of a question, on the packing of that world."""
    p = packing_of(world)
    if question in ("bounded", "credible_intervals"):
        pytest.importorskip("clarabel")
    if question in ESTIMATORS:
        return ask_estimator(question, p)
    if question in ("npz", "store"):
        return globals()[f"ask_{question}"](p, world, folder)
    return globals()[f"ask_{question}"](p, world)


CELLS = [(question, world) for question, cells in TABLE.items() for world in cells]


@pytest.mark.filterwarnings("ignore::scaling.ImplausibleNoiseWarning")
@pytest.mark.parametrize(("question", "world"), CELLS, ids=[f"{q}-{w}" for q, w in CELLS])
def test_supported_and_right_or_refused_by_name(question, world, tmp_path):
    if TABLE[question][world] != "yes":
        with pytest.raises(ValueError, match=TABLE[question][world]):
            answer(question, world, tmp_path)
        return
    shown = answer(question, world, tmp_path)
    assert shown.error < shown.bound < shown.wrong


def test_a_law_made_for_other_contacts_is_named():
    """That of the whole for a part: by its name, its constants and its number of contacts."""
    p = packing_of("Hertz")
    part = network_of(p).inside(p.positions[:, 1] < p.positions[:, 1].mean(), p.normal_forces)
    said = f"Hertz(stiffness=1.0, poisson=0.3) of {len(p.pairs)} contacts"
    with pytest.raises(ValueError, match=re.escape(said) + f" is not one of {part.contacts}"):
        reconstruct(part, p.law)
    with pytest.raises(ValueError, match=re.escape(said) + " is none"):
        reconstruct(network_of(p), p.law, "balanced")


def test_every_estimator_has_its_row():
    assert set(ESTIMATORS) <= set(TABLE)


def test_the_page_shows_this_table():
    """Question, then one cell a world: yes, or no with the letter of the words of the refusal."""
    page = (ROOT / "docs" / "howto" / "walls_and_weight.md").read_text(encoding="utf-8")
    lines = [line for line in page.splitlines() if re.match(r"\| `\w+` \|.* (yes|no)", line)]
    cells = [[cell.strip() for cell in line.strip("| ").split("|")] for line in lines]
    shown = {name.strip("`"): dict(zip(WORLDS, row, strict=True)) for name, *row in cells}
    words = dict(re.findall(r'^- \((\w)\) "(.*)"$', page, re.MULTILINE))
    letters = {said: letter for letter, said in words.items()}
    assert len(letters) == len(words)
    for question, wanted in TABLE.items():
        for world, word in wanted.items():
            cell = word if word == "yes" else f"no ({letters[word]})"
            assert shown[question][world] == cell, (question, world)
    assert set(shown) == set(TABLE)
    assert set(letters) == {w for row in TABLE.values() for w in row.values()} - {"yes"}
