"""A list of contacts that ends too early, where the file does not say how long it should be.

Where forces follow the overlaps, grains that overlap push: overlapping pairs that are not listed
are missing from the list. Few of them may be rattlers that were left out; many are half a list.
"""

from __future__ import annotations

import numpy as np

from packing.contact_law import law_between
from packing.contacts.contact_search import infer_contacts
from packing.files.problem import FileProblem
from packing.files.snapshot import Snapshot
from packing.note import Note
from packing.reading.fitted_law import shown_law
from packing.reading.law_found import GOOD
from packing.seen import Seen

_MANY = 0.02
"""Of the listed contacts between grains."""
_PUSHING = 0.1
"""Of the mean force: what a missing pair has to push with by the law."""


def refuse_half_a_list(s: Snapshot) -> None:
    """FileProblem "cut-short": grains overlap, push by the law of others, and are not listed."""
    seen = Seen.of(s)
    if seen.overlaps is None or seen.normal is None or s.radii is None or not len(seen.pairs):
        return
    best = shown_law(seen.overlaps, seen.normal, s.radii, seen.pairs)[0]
    if best is None or best.misfit > GOOD:
        return
    try:
        pairs, images = infer_contacts(s.positions, s.radii, cell=s.cell)
    except ValueError:  # a cell or radii with which nothing can be inferred
        return
    branches = Seen.of(s).boundary.branches(s.positions, pairs, images)
    overlaps = s.radii[pairs].sum(axis=1) - np.hypot(*branches.T)
    force = law_between(best.law, s.radii, pairs).force(overlaps)
    found = pairs[force > _PUSHING * seen.normal.mean()]
    inner = seen.pairs[seen.pairs[:, 1] < seen.grains]
    count = seen.grains
    missing = ~np.isin(found @ [count, 1], inner @ [count, 1])
    if missing.sum() <= _MANY * len(inner):
        return
    last = None if s.contact_lines is None else int(s.contact_lines.max())
    i, j = found[np.argmax(missing)].tolist()
    raise FileProblem(
        Note(
            "error",
            "cut-short",
            f"{missing.sum()} pairs of grains overlap and are not among the "
            f"{len(inner)} contacts listed, grains {i} and {j} (counted from 0) say: the list is "
            "cut off",
            s.contact_source or s.source,
            last,
            int(missing.sum()),
        )
    )
