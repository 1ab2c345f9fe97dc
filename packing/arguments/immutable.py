"""Records stay read-only on their way through pickle and copy.

NumPy does not keep the flag `writeable` of an array that is pickled or copied, so a record sent
to a worker process would come back changeable, and numbers kept from before would then disagree
with those changed.
"""

from __future__ import annotations

from dataclasses import fields, is_dataclass
from typing import Any, TypeVar

import numpy as np

T = TypeVar("T")


class Immutable:
    """Base of records whose arrays are read-only: they are so after pickle and copy, too."""

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update({name: read_only(value) for name, value in state.items()})


def read_only(value: T) -> T:
    """`value` with its arrays read-only: itself, entries of a sparse matrix, fields of a record.

    Tuples, lists and dictionaries are followed too; what is Immutable itself looks after its own
    arrays, and anything else is left alone.
    """
    if isinstance(value, np.ndarray):
        value.flags.writeable = False
    elif isinstance(value, dict):
        for each in value.values():
            read_only(each)
    elif isinstance(value, tuple | list):
        for each in value:
            read_only(each)
    elif is_dataclass(value) and not isinstance(value, type | Immutable):
        for f in fields(value):
            read_only(getattr(value, f.name, None))
    elif hasattr(value, "indptr") and hasattr(value, "sum_duplicates"):
        # Compressed sparse rows or columns: SciPy adds up duplicates in place, on demand.
        sparse: Any = value
        sparse.sum_duplicates()
        sparse.data.flags.writeable = False
    return value
