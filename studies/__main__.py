"""What the figures and pages show, computed and written as tables.

python -m studies [NAME ...]           quick, to build/results/ (tables of figures: build/figures/)
python -m studies [NAME ...] --full    as the docs have them, to results/ (figures/)

Without a name: all but the tables of figures, which ``python -m paper_figs`` makes too. Of the
figures:

collapse           E against ξ/Δ: Fig. 1
loop_sums          loop sums over Δ, singular values: Fig. 2
force_chains       forces of one packing at three noises: Fig. 3
estimator_errors   E of all estimators: Fig. 4
prefactor_laws     gains of all estimators: Fig. 5
error_maps         error of every contact, worst noise: Fig. 6
experiment_errors  contacts misread, scales, digits: Fig. 7
grains             the packing of Figs. 3 and 6
worlds             E of every scene, with walls, weight, Hertz: Fig. 8
world_layers       the layers of packings under weight: Fig. 8
packing_table      Table 1

Of docs/estimators.md, from packings of the store; missing ones are made (a minute with Numba):

laws         gains against loops per contact and hyperstaticity per unknown, over friction and N
prefactor    these laws on packings they were not found on, and what explains them
measures     C for two noises and three measures of the error, beside the Comment's 0.3
finite_size  K²/ℓ over N, and the b of its growth 1 + b/N, without and with the windings
positions    how fast redundant radii are lost: the bound for noise ξ on diameters, ζ on positions
ratio        balanced over gppsz over N and Δ
ladder       what is known without any size or distance, and from what
ridge        what stops the error at large noise: the prior, or the inequalities
sensitivity  of `bounded` to a wrong friction, pressure or ξ
stress       the modes that sizes and exact directions leave open, and what the mean stress closes
anisotropy   the components of the mean stress that pressure control leaves free
prior        what the prior of `bounded` does
coverage     of the credible intervals
stiffness    wrong by one factor, spread over contacts, or the wrong contact law
million_grains  assembly, forces and prefactor of a million grains on one core

Of docs/trade.md:

dem_trade     what each setting of the DEM costs and what it changes
same_packing  whether Newton's method ends in the same packing whenever time steps stop
late_drag     what a lower drag at the end of large cells changes, and saves
same_statistics  whether Z, φ and P(f) are those that time steps alone would reach
hertz         packings of elastic spheres: rest, prefactor, and the cost of reading them as linear
between_walls  what walls and weight do to Eq. 1: rank, condition, the cost of a length
silo          what side walls bear of the weight: Janssen's law
sandpile      sand of glass and quartz in real units, at four depths
ramps         pressure up and down again
ramp_rates    what the rate of a ramp changes
continuation  packings continued by Newton's method against integrated ones
rounding      coordinates with few digits lie on the collapse
floor         the error left without noise, naive and compensated arithmetic

Of docs/real_data.md, from packings of other groups in the folder that PACKING_DATA names; skipped
without it:

foreign       a frictional packing of another group beside three of ours, noise from 0.1 to 30 Δ
photoelastic  what gaps and balance say of the forces in photoelastic disks

Those that print a table line by line (laws to ratio, stress, anisotropy, coverage, stiffness) are
the same in both editions.
"""

from __future__ import annotations

from collections.abc import Sequence

from studies.command_line import one_of, parser
from studies.of_figures import OF_FIGURES
from studies.registry import STUDIES
from studies.run import Run


def main(words: Sequence[str] | None = None) -> None:
    """The studies named, or all that are not of figures."""
    line = parser("studies", __doc__)
    line.add_argument("--full", action="store_true", help="the edition of the docs")
    line.add_argument(
        "study", nargs="*", type=one_of(STUDIES, "study"),
        help="default: all but the tables of figures",
    )  # fmt: skip
    arguments = line.parse_args(words)
    run = Run.of(arguments.full)
    for name in arguments.study or [n for n in STUDIES if n not in OF_FIGURES]:
        STUDIES[name](run)
    run.report("in all")


if __name__ == "__main__":
    main()
