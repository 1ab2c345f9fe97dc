"""Mutations of the discrete element method: law, kernel, tangent, what is at rest."""

from __future__ import annotations

from tests.mutation.mutation import Mutation

DISKS = ("tests/dem/motion/test_two_disks.py",)
MOTION = ("tests/dem/motion/test_motion.py",)
POLISH = ("tests/dem/balance/test_newton.py",)
EXTENDED = ("tests/dem/protocols/test_stiffen.py",)
RATTLERS = ("tests/packing/contacts/test_rattlers.py",)
PACKING = ("tests/packing/test_record.py",)

WALLS = ("tests/dem/motion/test_walls.py",)
BETWEEN = ("tests/dem/protocols/test_between_walls.py",)

DEM = (
    Mutation(
        "walls: friction turns the grain the other way",
        "dem/motion/kernels/outside.py",
        "twist[grains] += tangential[some]",
        "twist[grains] -= tangential[some]",
        WALLS,
    ),
    Mutation(
        "walls: a corner pushes once",
        "dem/motion/kernels/outside.py",
        "for k in range(int(rank.max()) + 1)]",
        "for k in range(1)]",
        (*WALLS, *BETWEEN),
    ),
    Mutation(
        "walls: weight missing from the forces handed on",
        "dem/motion/kernels/outside_loop.py",
        "pull[g] += weight[g]",
        "pull[g] += 0.0 * weight[g]",
        (*WALLS, *BETWEEN),
    ),
    Mutation(
        "walls: compiled grains fall upwards",
        "dem/motion/kernels/outside_loop.py",
        "fall = complex(0.0, -gain * o[19])",
        "fall = complex(0.0, gain * o[19])",
        WALLS,
    ),
    Mutation(
        "walls: springs in another order than their contacts",
        "dem/model/neighbour_list.py",
        "return History(*(each[order] for each in all_))",
        "return History(all_[0][order], all_[1][order], all_[2])",
        WALLS,
    ),
    Mutation(
        "stable step: softer spring for stiffer",
        "dem/model/law.py",
        "max(self.stiffness, 2 * self.tangential)",
        "min(self.stiffness, 2 * self.tangential)",
        (*MOTION, *DISKS),
    ),
    Mutation(
        "kernel: slip by rolling, sign",
        "dem/motion/kernels/disks_numpy.py",
        "slip.real / r) - turn)",
        "slip.real / r) + turn)",
        DISKS,
    ),
    Mutation(
        "kernel: slip not in the frame at mid-step",
        "dem/motion/kernels/disks_numpy.py",
        "(1 - 0.5 * dt * slip.real / r)",
        "(1 + 0.5 * dt * slip.real / r)",
        (*DISKS, *MOTION),
    ),
    Mutation(
        "kernel: a sliding spring goes on stretching",
        "dem/motion/kernels/disks_numpy.py",
        "np.divide(tangential, k_t, out=u)",
        "pass",
        (*DISKS, *MOTION),
    ),
    Mutation(
        "kernel: approach by strain left out",
        "dem/motion/kernels/disks_numpy.py",
        "approach = slip.real + m.rate * r",
        "approach = slip.real",
        (*DISKS, *MOTION),
    ),
    Mutation(
        "kernel: drag not implicit",
        "dem/motion/kernels/disks_numpy.py",
        "gain = (before + after) / (1 + drive.drag * after)",
        "gain = before + after",
        (*DISKS, *MOTION),
    ),
    Mutation(
        "kernel: inertia of a ring",
        "dem/motion/kernels/disks_numpy.py",
        "m.s += 2 * gain * forces.twist / m.mass",
        "m.s += gain * forces.twist / m.mass",
        DISKS,
    ),
    Mutation(
        "kernel: a last kick too long",
        "dem/motion/kernels/disks_numpy.py",
        "0.0 if last else 0.5 * dt",
        "0.5 * dt",
        (*DISKS, *MOTION),
    ),
    Mutation(
        "tangent: load of the cell, factor 2",
        "dem/balance/tangent.py",
        "float(row[-1] - 2 * trial.load / self.span)",
        "float(row[-1] - trial.load / self.span)",
        POLISH,
    ),
    Mutation(
        "tangent: turned f_t, sign",
        "dem/balance/blocks.py",
        "a * n[q] + h * t[q]",
        "a * n[q] - h * t[q]",
        POLISH,
    ),
    Mutation(
        "rattlers: one contact more",
        "packing/contacts/rattlers.py",
        "return 2 if frictional else 3",
        "return 2 if frictional else 2",
        RATTLERS,
    ),
    Mutation(
        "rattlers: taken off once",
        "packing/contacts/rattlers.py",
        "        bearing &= ~drop\n",
        "        return bearing & ~drop\n",
        RATTLERS,
    ),
    Mutation(
        "extended precision: cell grows as it should shrink",
        "dem/balance/high_precision.py",
        "grow = DoubleDouble.of(1.0) + strain",
        "grow = DoubleDouble.of(1.0) - strain",
        EXTENDED,
    ),
    Mutation(
        "extended precision: low part of a side left out",
        "dem/balance/high_precision.py",
        "dx = self.x[j] - self.x[i] + self.sides[0] * images[:, 0]",
        "dx = self.x[j] - self.x[i] + self.sides[0].high * images[:, 0]",
        EXTENDED,
    ),
    Mutation(
        "tunnelling: smaller radius for larger",
        "dem/balance/missed_contacts.py",
        "max(state.radii[i], state.radii[j])",
        "min(state.radii[i], state.radii[j])",
        ("tests/dem/protocols/test_wrong_settings.py",),
    ),
    Mutation(
        "residual: torque on the second grain",
        "packing/packing_data.py",
        "np.add.at(twist, j, self.tangential_forces)",
        "np.add.at(twist, j, -self.tangential_forces)",
        PACKING,
    ),
)
