"""Records stay read-only on their way through pickle and copy.

NumPy does not keep the flag `writeable` of an array that is pickled or copied, so a record sent
to a worker process would come back changeable, and numbers kept from before would then disagree
with those changed.
"""

from __future__ import annotations

from typing import Any

import numpy as np


class Immutable:
    """Base of records whose arrays are read-only: they are so after pickle and copy, too."""

    def __setstate__(self, state: dict[str, Any]) -> None:
        for value in state.values():
            if isinstance(value, np.ndarray):
                value.flags.writeable = False
        self.__dict__.update(state)
