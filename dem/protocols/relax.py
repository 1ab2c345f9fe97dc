"""From scene to packing: compress a loose gas under pressure and drag until it rests, polish.

Below Δ = 1e-6 the packing of 1e-6 is continued to Δ by Newton's method alone (``dem.stiffen``).
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from dem.balance.newton import PolishFailed
from dem.protocols.loose_between_walls import loose_between_walls
from dem.protocols.loose_gas import draw_radii, loose_state
from dem.protocols.not_relaxed import NotRelaxed
from dem.protocols.plan import Plan, check_noise
from dem.protocols.relaxation import come_to_rest, named
from dem.protocols.stage import state_of
from dem.protocols.stiffen import stiffen
from dem.scene import Scene
from dem.settings import Settings
from packing.arguments.numbers import instance, seed_number
from packing.progress import hidden
from packing.record import Packing

#: Below this Δ packings come by continuation, in extended precision.
CONTINUED_BELOW = 1e-6
#: Where continuation starts; the next is tried if the contacts of the last cannot be continued.
CONTINUED_FROM = (1e-6, 5e-7, 2.5e-7)


def relax(
    scene: Scene,
    seed: int,
    *,
    settings: Settings = Settings(),  # noqa: B008  (frozen)
    progress: bool | None = None,
) -> Packing:
    """A packing of ``scene``, from random positions drawn with ``seed``.

    Parameters
    ----------
    scene : Scene
        What is packed.
    seed : int
        Whole number >= 0.  Same scene, seed, settings and backend: the same packing, bit for bit,
        on the same machine.
    settings : Settings
        How it is brought to rest.
    progress : bool, optional
        None shows a bar on a terminal only, False never.

    Returns
    -------
    Packing
        At rest.  With Δ < 1e-6 and the polish it carries low parts and is a continuation of the
        one at 1e-6.

    Raises
    ------
    ValueError
        Before any work: a scene whose cell is too narrow for its grains; a seed that is no whole
        number >= 0; float32 with Δ < 1e-4; more than 1e8 time steps to the end of
        ``settings.longest``; a contact law that is not linear with Δ < 1e-6 or float32, one of
        somebody else's with a compiled kernel.
    NotRelaxed
        Rest was not reached within ``settings.longest`` inertial times; continuation to Δ < 1e-6
        stopped on the way, from each start.

    Notes
    -----
    A gas at area fraction 0.70 is compressed under the pressure p = Δ κ against viscous drag, as
    DeGiuli and McElwaine do (PRL 116, 078001 (2016)), then polished by Newton's method.

    Examples
    --------
    >>> from dem import Scene, relax
    >>> packing = relax(Scene(grains=20, delta=1e-2), seed=1, progress=False)
    >>> f"{packing.delta:g}", bool(packing.residuals().max() < 1e-9)
    ('0.01', True)
    """
    instance("scene", scene, Scene)
    instance("settings", settings, Settings)
    seed = seed_number(seed)
    hidden(progress)
    check_noise(scene.delta, settings)
    if settings.polish and scene.delta < CONTINUED_BELOW:
        return _continued(scene, seed, settings, progress)
    return _integrated(scene, seed, settings, progress)


def _integrated(scene: Scene, seed: int, settings: Settings, progress: bool | None) -> Packing:
    radii = draw_radii(scene, np.random.default_rng(seed))
    Plan.of(scene, settings, radii)  # refuses before any work
    start = loose_state if scene.confinement is None else loose_between_walls
    state = start(scene, np.random.default_rng(seed))
    return come_to_rest(state, scene, seed, settings, progress)


def _continued(scene: Scene, seed: int, settings: Settings, progress: bool | None) -> Packing:
    if scene.confinement is not None:
        raise ValueError(
            f"boundary = {scene.boundary!r}: packings with delta = {scene.delta:g}, below "
            f"{CONTINUED_BELOW:g}, are continued, and that knows no walls"
        )
    if not scene.is_linear:
        raise ValueError(
            f"contact = {scene.contact!r}: packings with delta = {scene.delta:g}, below "
            f"{CONTINUED_BELOW:g}, are continued, and that knows linear springs only"
        )
    for delta in (d for d in CONTINUED_FROM if d > scene.delta):
        softer = replace(scene, delta=delta)
        packing = _integrated(softer, seed, settings, progress)
        try:
            return stiffen(packing, scene.delta, progress=progress)
        except PolishFailed as failure:
            why, reached = failure, packing
    speed, residual = reached.provenance.speed, reached.provenance.residual
    assert speed is not None
    assert residual is not None
    state, message = state_of(reached, scene), f"{named(scene, seed)}{why}"
    raise NotRelaxed(message, state, speed, residual) from why
