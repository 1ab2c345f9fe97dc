"""The verbs, what they are told on the command line, and an example of each.

Nothing is loaded here but the parser's own module: help is at hand at once.
"""

from __future__ import annotations

import argparse
import ast
from argparse import ArgumentParser
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

METHODS = ("gppsz", "balanced", "direct", "optimal", "bounded", "transverse")
MATERIALS = ("glass", "steel", "sand", "rubber", "photoelastic", "hydrogel")
BOUNDARIES = ("periodic", "walls", "box")
FIGURES = 8
FEWEST_DRAWS = 8


@dataclass(frozen=True)
class Verb:
    """What it does, in a line and at length, an example, and what declares its arguments."""

    about: str
    example: str
    declare: Callable[[ArgumentParser], None]
    long: str = ""


def number(word: str) -> float:
    """A finite number."""
    try:
        value = float(word)
    except ValueError:
        raise argparse.ArgumentTypeError(f"{word}: no number") from None
    if not abs(value) < float("inf"):
        raise argparse.ArgumentTypeError(f"{word}: not finite")
    return value


def from_zero(word: str) -> float:
    """A number that is not negative."""
    value = number(word)
    if value < 0:
        raise argparse.ArgumentTypeError(f"{word}: negative")
    return value


def positive(word: str) -> float:
    """A number above zero."""
    value = number(word)
    if value <= 0:
        raise argparse.ArgumentTypeError(f"{word}: not above 0")
    return value


def whole(word: str) -> int:
    """A whole number from 0."""
    if not word.isdecimal():
        raise argparse.ArgumentTypeError(f"{word}: expected a whole number")
    return int(word)


def ending(*endings: str) -> Callable[[str], str]:
    """Takes the name of a file that ends in one of these."""

    def name(word: str) -> str:
        if not word.lower().endswith(endings):
            raise argparse.ArgumentTypeError(f"{word}: expected a name in {' or '.join(endings)}")
        return word

    return name


def draws(word: str) -> int:
    """A number of draws that gives an interval."""
    if (count := whole(word)) < FEWEST_DRAWS:
        raise argparse.ArgumentTypeError(f"{word}: an interval takes {FEWEST_DRAWS} or more")
    return count


def setting(word: str) -> tuple[str, Any]:
    """NAME=VALUE; the value as Python would read it, or as text."""
    name, given, value = word.partition("=")
    if not given or not name.isidentifier():
        raise argparse.ArgumentTypeError(f"{word}: expected NAME=VALUE")
    try:
        return name, ast.literal_eval(value)
    except (ValueError, SyntaxError):
        return name, value


def _files(line: ArgumentParser) -> None:
    line.add_argument(
        "files", nargs="+", metavar="FILE",
        help="a packing: npz, CSV, or what LAMMPS, LIGGGHTS, YADE, MercuryDPM, PeGS write",
    )  # fmt: skip
    line.add_argument("--format", metavar="NAME", help="of the file; left out, it is recognised")
    line.add_argument(
        "--contacts", metavar="FILE",
        help="a second file that holds the contacts; left out, one beside FILE whose name says so",
    )  # fmt: skip
    line.add_argument(
        "--set", action="append", type=setting, metavar="NAME=VALUE",
        help="an option of the format, several times if need be: --set sizes=diameters",
    )  # fmt: skip


def _data(line: ArgumentParser) -> None:
    _files(line)
    told = line.add_argument_group("what you know (in the units of the file)")
    told.add_argument(
        "--stiffness", type=positive, metavar="κ",
        help="of a contact, a linear spring: its normal force over its overlap",
    )  # fmt: skip
    told.add_argument("--friction", type=from_zero, metavar="μ", help="Coulomb coefficient")
    told.add_argument(
        "--pressure", type=positive, metavar="p", help="in two dimensions: force per length"
    )
    told.add_argument(
        "--noise", type=from_zero, metavar="ξ",
        help="standard deviation of a coordinate; left out, that of rounding",
    )  # fmt: skip
    told.add_argument(
        "--size-noise", type=from_zero, metavar="ξ",
        help="standard deviation of a diameter; of the two noises, one told alone: the other is 0",
    )  # fmt: skip
    told.add_argument(
        "--gap", type=from_zero, default=0.0, metavar="g",
        help="where no contacts are listed: grains closer than this touch",
    )  # fmt: skip


def _read(line: ArgumentParser) -> None:
    _files(line)
    line.add_argument(
        "--out", metavar="FILE", type=ending(".npz", ".csv"),
        help="npz, or CSV tables by its ending; default: NAME.npz here",
    )  # fmt: skip


def _solving(line: ArgumentParser) -> None:
    _data(line)
    line.add_argument("--method", choices=METHODS, help="left out, the best of what is known")
    line.add_argument(
        "--draws", type=draws, metavar="n",
        help="for intervals of bounded; default 8000/N, within 8 and 40",
    )  # fmt: skip


def _forces(line: ArgumentParser) -> None:
    _solving(line)
    line.add_argument(
        "--out", metavar="FILE", type=ending(".csv", ".vtk"),
        help="CSV, or VTK by its ending; default: NAME-forces.csv here",
    )  # fmt: skip
    line.add_argument(
        "--picture", metavar="FILE", type=ending(".png", ".pdf", ".svg"),
        help="PNG, PDF or SVG of the force chains",
    )  # fmt: skip


def _report(line: ArgumentParser) -> None:
    _solving(line)
    line.add_argument(
        "--out", metavar="FILE", type=ending(".html", ".htm"),
        help="default: NAME-report.html here",
    )  # fmt: skip


def _need(line: ArgumentParser) -> None:
    line.add_argument("--material", choices=MATERIALS, help="instead of --modulus and --poisson")
    line.add_argument("--modulus", type=positive, metavar="E", help="Young's modulus, Pa")
    line.add_argument("--poisson", type=number, metavar="ν", help="default 0.3")
    line.add_argument("--pressure", type=positive, metavar="p", help="Pa")
    line.add_argument("--diameter", type=positive, metavar="d", help="mean diameter, m")
    line.add_argument("--law", choices=("hertz", "linear"), default="hertz", help="default hertz")
    line.add_argument(
        "--error", type=positive, default=0.1, metavar="E",
        help="that forces may have, over the mean force; default 0.1",
    )  # fmt: skip


def _prepare(line: ArgumentParser) -> None:
    line.add_argument("out", metavar="OUT.npz", type=ending(".npz"), help="the packing")
    line.add_argument("--grains", type=whole, default=1000, metavar="N", help="default 1000")
    line.add_argument(
        "--delta", type=positive, default=1e-4, metavar="Δ",
        help="deformation of the grains by the pressure, in mean diameters; default 1e-4",
    )  # fmt: skip
    line.add_argument(
        "--friction", type=from_zero, default=0.3, metavar="μ",
        help="Coulomb coefficient; default 0.3",
    )  # fmt: skip
    line.add_argument(
        "--polydispersity", type=from_zero, default=0.3, metavar="s",
        help="radii are uniform within ± s of their mean; default 0.3",
    )  # fmt: skip
    line.add_argument(
        "--boundary", choices=BOUNDARIES, default="periodic",
        help="walls: floor and pressed top; box: sides too; default periodic",
    )  # fmt: skip
    line.add_argument(
        "--contact", choices=("linear", "hertz"), default="linear",
        help="springs, or elastic spheres; default linear",
    )  # fmt: skip
    line.add_argument(
        "--gravity", type=from_zero, default=0.0, metavar="g",
        help="in κ/(ρ⟨σ⟩²), between walls: at p/10 ten grains weigh as the top presses; default 0",
    )  # fmt: skip
    line.add_argument(
        "--seed", type=whole, default=1, metavar="n", help="of another packing; default 1"
    )
    line.add_argument("--quiet", action="store_true", help="no bar of progress")


def _figure(line: ArgumentParser) -> None:
    line.add_argument(
        "number", type=whole, choices=range(1, FIGURES + 1), metavar="N",
        help=f"of the paper, 1 to {FIGURES}",
    )  # fmt: skip
    line.add_argument("--full", action="store_true", help="the publication edition, long")


VERBS: dict[str, Verb] = {
    "read": Verb(
        "any format to npz, and what was understood of it",
        "packing-forces read atoms.dump --contacts contacts.dump --set radius=0.5",
        _read,
    ),
    "check": Verb(
        "can forces be had? counts, digits, balance, friction, gaps, rank",
        "packing-forces check packing.npz",
        _data,
    ),
    "forces": Verb(
        "the forces by the best method, as CSV with error bars",
        "packing-forces forces packing.npz --noise 1e-5 --picture chains.png",
        _forces,
    ),
    "report": Verb(
        "all of it as one page: chains, errors, verdict",
        "packing-forces report packing.npz --noise 1e-5 --out report.html",
        _report,
    ),
    "need": Verb(
        "how exactly a packing must be measured, before it is",
        "packing-forces need --material glass --pressure 2e3 --diameter 1e-3",
        _need,
    ),
    "prepare": Verb(
        "a packing of your own, from a scene",
        "packing-forces prepare packing.npz --grains 1000 --delta 1e-4",
        _prepare,
    ),
    "figure": Verb(
        "a figure of the paper, with its tables",
        "packing-forces figure 6",
        _figure,
    ),
}  # fmt: skip
