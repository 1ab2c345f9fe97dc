"""The name of a packing in a store: a hash of all that decides it.

Fields of scene and settings that have their default values are left out, so that a field added
later, whose default means what went before, leaves all names as they are.  A default that
changes its value changes what ``relax`` returns, and asks for another ``ALGORITHM``.
"""

from __future__ import annotations

import hashlib
import json
from dataclasses import MISSING, fields
from typing import Any

from dem.model.large_cells import MANY
from dem.motion.backends import resolve_backend
from dem.protocols.relax import CONTINUED_BELOW
from dem.scene import Scene
from dem.settings import Settings
from packing.arguments.numbers import instance, seed_number

#: Part of the key: raise it when ``relax`` changes what it returns for a seed.
ALGORITHM = 9
#: The same for packings of more than ``MANY`` grains, whose drag falls at the end.
LARGE_CELLS = 1
#: The same for packings with Δ < 1e-6, which are continued from 1e-6.
CONTINUATION = 1
#: Part of the key: how it is made; 1 had the fields at their defaults, too.
FORMAT = 2


def packing_key(scene: Scene, seed: int, settings: Settings) -> str:
    """The name of a packing in a store, so that no store answers with somebody else's packing.

    Parameters
    ----------
    scene : Scene
        What is packed.
    seed : int
        Whole number >= 0.
    settings : Settings
        How; the backend counts as the one that runs here.

    Returns
    -------
    str
        24 hexadecimal digits.

    Raises
    ------
    ValueError
        What is no scene, seed or settings.

    Examples
    --------
    >>> from dem import Scene, Settings, packing_key
    >>> len(packing_key(Scene(20, 1e-2), 1, Settings()))
    24
    """
    scene, settings = instance("scene", scene, Scene), instance("settings", settings, Settings)
    facts = {
        "scene": without_defaults(scene, scene.plain()),
        "seed": seed_number(seed),
        "settings": without_defaults(settings, settings.plain())
        | {"backend": resolve_backend(settings.backend)},
        "format": FORMAT,
        "algorithm": ALGORITHM,
    }
    if scene.grains > MANY:
        facts["large cells"] = LARGE_CELLS
    if settings.polish and scene.delta < CONTINUED_BELOW:
        facts["continuation"] = CONTINUATION
    return hashlib.sha256(json.dumps(facts, sort_keys=True).encode()).hexdigest()[:24]


def without_defaults(record: Scene | Settings, known: dict[str, Any]) -> dict[str, Any]:
    """``known``, values of fields by name, without those that have the default of ``record``."""
    default = {f.name: f.default for f in fields(record) if f.default is not MISSING}
    return {k: v for k, v in known.items() if k not in default or v != default[k]}
