"""What an estimator is: options of its own, and forces from an equation.

    class Mine(LinearEstimator):             frozen dataclass, its options as fields
        name = "mine"
        def find(self, equation): ...        the forces, as a `reconstruction`
        def respond(self, at, η): ...        only of linear ones: what noise does to them

in one file, and one line in `scaling.estimators.table`. Refused, whatever the estimator: loads
that no forces balance (`scaling.equation.loads`, `scaling.equation.mechanisms`), and grains that
overlap by a good part of their size where overlaps become forces
(`scaling.estimators.plausibility`).
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import Any, ClassVar

import numpy as np

from packing.arguments.arrays import Floats
from packing.arguments.numbers import shown
from packing.contact_law import ContactLaw
from scaling.algebra.evidence import NotAccurate, Solved
from scaling.equation.force_equation import ForceEquation
from scaling.equation.loads import refuse_unbalanced
from scaling.equation.mechanisms import refuse_mechanisms
from scaling.estimators.plausibility import refuse_deep_overlaps
from scaling.estimators.reconstruction import Reconstruction
from scaling.estimators.response import Response
from scaling.noise.noise_model import NoiseModel

SOLVERS = ("auto", "dense", "factor", "lsmr")


class Estimator(ABC):
    """Forces of an equation, by one method.

    The base of all estimators: frozen dataclasses whose fields are their options.

    Examples
    --------
    >>> from scaling.estimators import Bounded, Gppsz
    >>> [issubclass(kind, Estimator) for kind in (Gppsz, Bounded)]
    [True, True]
    """

    name: ClassVar[str]
    """In the table of estimators, and in messages."""
    closes_windings: ClassVar[bool] = False
    """Whether it can use an equation with the windings among its loops."""

    def solve(self, equation: ForceEquation) -> Reconstruction:
        """The forces of `equation`, which knows its law: `force_equation(...).with_law(κ)`.

        Parameters
        ----------
        equation : ForceEquation
            Eq. 1 of a network

        Returns
        -------
        Reconstruction
            The forces, with what is left of the equations.

        Raises
        ------
        ValueError
            An option that this equation cannot take, no unique solution, with the rank,
            loads that cannot be balanced, or overlaps that are none
        RuntimeError
            An iteration or the convex solver broke down
        """
        if self.uses_overlaps(equation):
            refuse_deep_overlaps(equation.network)
        self.refuse_free(equation)
        if self.errs(equation):
            return self.find(equation)
        refuse_unbalanced(equation)
        try:
            found = self.find(equation)
        except (RuntimeError, NotAccurate):
            refuse_mechanisms(equation)  # if that is why the solver broke down
            raise
        refuse_mechanisms(equation, found.forces)
        return found

    def errs(self, equation: ForceEquation) -> bool:
        """Whether loads are told with error bars: then `find` judges them."""
        return False

    def refuse_free(self, equation: ForceEquation) -> None:
        """ValueError: a contact of two free grains, whose tangential force is in no balance."""
        network = equation.network
        if not (equation.frictional and network.free.any()):
            return
        i, j = network.pairs[: network.inner].T
        lost = np.flatnonzero(network.free[i] & network.free[j])
        if len(lost):
            e = lost[0]
            raise ValueError(
                f"contact {e} joins grains {i[e]} and {j[e]}, both free, one of {len(lost)}: its "
                f"tangential force is in no balance, and method {self.name!r} cannot find it; "
                "leave such contacts out, or ask 'bounded', which has a prior"
            )

    @abstractmethod
    def find(self, equation: ForceEquation) -> Reconstruction:
        """`solve` without the checks of loads and overlaps."""

    def check_kind(self, frictional: bool, winding: bool) -> None:
        """ValueError for an equation, with or without friction and windings, of no use to it."""
        if winding and not self.closes_windings:
            raise ValueError(f"method {self.name!r} does not use winding")

    def uses_overlaps(self, equation: ForceEquation) -> bool:
        """Whether sizes enter the forces."""
        return True

    def law(self, equation: ForceEquation) -> ContactLaw:
        """The law of the equation; ValueError if it was not told one."""
        if equation.law is None:
            raise ValueError(f"method {self.name!r} needs the stiffness")
        return equation.law

    def stiffness(self, equation: ForceEquation) -> float:
        """κ, or the mean of κ_e; ValueError if the law is not linear."""
        law = self.law(equation)
        if not equation.linear:
            raise ValueError(
                f"method {self.name!r} takes linear laws only: stiffness = {shown(law)} is none"
            )
        return equation.stiffness


class LinearEstimator(Estimator):
    """An estimator whose forces are linear in the data, so that its errors follow exactly.

    Examples
    --------
    >>> from scaling.estimators import Bounded, Gppsz
    >>> [issubclass(kind, LinearEstimator) for kind in (Gppsz, Bounded)]
    [True, False]
    """

    def response(
        self, equation: ForceEquation, noise: NoiseModel, lengths: Floats | None = None
    ) -> Response:
        """What noise in the data does to the forces, to first order: η -> δf/(κ ξ).

        Parameters
        ----------
        equation : ForceEquation
            At the noise-free network
        noise : NoiseModel
            Which data are noisy, and how strongly
        lengths : numpy.ndarray
            (2c,) or (c,) φ = f/κ of the forces at which directions turn in M; by default
            directions count as exact there
        """
        return Response(self, equation, noise, lengths)

    def prepared(self, at: Response) -> Any:
        """What is solved with for every η, made once; None if there is nothing to make."""
        return None

    @abstractmethod
    def respond(self, at: Response, η: Floats) -> Solved:
        """(k, m) noise -> (2c, m) lengths δf/(κ ξ) at `at`; (c, m) if frictionless."""
