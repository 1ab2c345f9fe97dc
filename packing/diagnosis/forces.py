"""What forces show: pairs that bear none, too much friction, grains that do not balance."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from packing.note import Note
from packing.seen import Seen

BALANCED = 0.01
"""Net forces up to this part of ⟨f_n⟩ count as balanced."""
_RIM = 0.5
"""Grains whose edge is nearer than this, in ⟨σ⟩, to the box around all lie at the rim."""


def forces(seen: Seen, friction: float | None) -> Iterator[Note]:
    """Contacts without a force, or with more friction than Coulomb allows."""
    f_n, f_t = seen.normal, seen.tangential
    if f_n is None or not len(f_n):
        return
    none = f_n == 0
    if f_t is not None:
        none &= f_t == 0
    if none.any():
        yield Note(
            "information",
            "zero-force",
            f"{none.sum()} of {len(none)} contacts bear no force",
            number=int(none.sum()),
        )
    if friction is not None and f_t is not None:
        excess = np.abs(f_t) - friction * f_n - BALANCED * np.abs(f_n).mean()
        if (excess > 0).any():
            e = int(excess.argmax())
            yield Note(
                "warning",
                "beyond-coulomb",
                f"{(excess > 0).sum()} of {len(f_n)} contacts bear more "
                f"friction than {friction:g}: contact {tuple(seen.pairs[e].tolist())} has "
                f"f_n = {f_n[e]:.3g}, f_t = {f_t[e]:.3g}",
                number=int((excess > 0).sum()),
            )


def balance(seen: Seen) -> Iterator[Note]:
    """How well forces balance; if they do not, whether walls are missing."""
    worst = seen.unbalanced
    if worst is None:
        return
    loud = worst > BALANCED
    if not loud.any():
        yield Note(
            "information",
            "balance",
            f"forces and torques balance to {worst.max():.1e} ⟨f_n⟩ on "
            f"the worst grain, {np.sqrt(np.mean(worst**2)):.1e} rms",
            number=float(worst.max()),
        )
        return
    k = int(worst.argmax())
    share = (
        f"{loud.sum()} of {seen.grains} grains are not balanced, grain {k} worst: {worst[k]:.3g}"
    )
    if at_rim(seen, loud):
        yield Note(
            "warning",
            "missing-walls",
            f"{share} ⟨f_n⟩. All lie at the rim, and are pushed outwards: "
            "the walls that hold them are missing",
            number=int(loud.sum()),
        )
    else:
        yield Note(
            "warning",
            "not-at-rest",
            f"{share} ⟨f_n⟩; the rms over all is {np.sqrt(np.mean(worst**2)):.2g}",
            number=float(worst[k]),
        )


def at_rim(seen: Seen, loud: np.ndarray) -> bool:
    """Whether these grains of an open packing, but not all grains, lie at its rim and are pushed
    outwards."""
    if seen.boundary.cell is not None or seen.net is None or loud.all():
        return False
    rims = np.zeros(seen.grains) if seen.radii is None else seen.radii
    low, high = seen.positions - rims[:, None], seen.positions + rims[:, None]
    gaps = np.concatenate([low - low.min(axis=0), high.max(axis=0) - high], axis=1)
    outwards = gaps < _RIM * seen.size
    push = np.concatenate([-seen.net[:, :2], seen.net[:, :2]], axis=1)
    pushed = np.sum(outwards & (push > 0), axis=1) > 0
    rim = np.sum(outwards, axis=1) > 0
    return bool(np.all(rim[loud]) and np.mean(pushed[loud]) > 0.9)


def rattlers(seen: Seen, listed: bool) -> Iterator[Note]:
    """Grains without a contact."""
    if not listed:
        return
    loose = np.bincount(seen.pairs.ravel(), minlength=seen.grains)[: seen.grains] == 0
    if loose.any():
        yield Note(
            "information",
            "rattlers",
            f"{loose.sum()} of {seen.grains} grains touch nothing",
            number=int(loose.sum()),
        )
