"""Studies of the estimators behind docs/estimators.md, one table each.

    python -m benchmarks.estimators [laws] [prefactor] [measures] [size] [positions] [ratio]
                                    [ladder] [ridge] [sensitivity] [stress] [anisotropy]
                                    [prior] [coverage] [stiffness] [time]

laws       gains against loops per contact and hyperstaticity per unknown, over friction and N
prefactor  these laws on packings they were not found on, and the decomposition that explains them
measures   C for two noises and three measures of the error, beside the Comment's 0.3
size       the same K²/ℓ over N, and the b of its growth 1 + b/N, without and with the windings
positions  how fast redundant radii are lost: the bound for noise ξ on diameters, ζ on positions
ratio      balanced over gppsz over N and Δ
ladder     what is known without any size or distance, and from what
ridge      what stops the error at large noise: the prior, or the inequalities
sensitivity  of `bounded` to a wrong friction, pressure or ξ
stress     the modes that sizes and exact directions leave open, and what the mean stress closes
anisotropy  the components of the mean stress that pressure control leaves free
prior      what the prior of `bounded` does
coverage   of the credible intervals
stiffness  wrong by one factor, spread over contacts, or the wrong contact law
time       per solve against N, with the exponent

Packings come from the store of the figures; missing ones are made (a minute with Numba). What
ladder, ridge, sensitivity and prior print goes to benchmarks/results/ too, as CSV and figures.
"""

from __future__ import annotations

import time

from benchmarks.studies.anisotropy import anisotropy
from benchmarks.studies.bound import positions, ratio
from benchmarks.studies.cost import times
from benchmarks.studies.ladder import ladder
from benchmarks.studies.laws import laws
from benchmarks.studies.measures import measures
from benchmarks.studies.prefactor import prefactor
from benchmarks.studies.prior import measure_coverage, prior
from benchmarks.studies.ridge import ridge
from benchmarks.studies.sensitivity import sensitivity
from benchmarks.studies.size import size
from benchmarks.studies.stiffness import stiffness
from benchmarks.studies.stress import stress
from paper_figs.command import one_of, parser

STUDIES = {
    "laws": laws, "prefactor": prefactor, "measures": measures, "size": size,
    "positions": positions, "ratio": ratio, "ladder": ladder, "ridge": ridge,
    "sensitivity": sensitivity, "stress": stress, "anisotropy": anisotropy, "prior": prior,
    "coverage": measure_coverage, "stiffness": stiffness, "time": times,
}  # fmt: skip


def main() -> None:
    """The studies named, or all."""
    line = parser("benchmarks.estimators", __doc__)
    line.add_argument("study", nargs="*", type=one_of(STUDIES, "study"), help="default: all")
    for name in line.parse_args().study or STUDIES:
        start = time.perf_counter()
        print(f"\n## {name}\n")
        STUDIES[name]()
        print(f"\n({time.perf_counter() - start:.0f} s)", flush=True)


if __name__ == "__main__":
    main()
