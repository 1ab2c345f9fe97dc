"""Relaxed packings as networks, and the bounded problem of one with noisy positions."""

from __future__ import annotations

import numpy as np

from scaling import ContactNetwork, perturb
from scaling.estimators.bounded.posterior import posterior
from scaling.noise.noise_model import noise_model


def network_of(p):
    return ContactNetwork.from_packing(p)


def noisy_problem(p, xi, seed, frictional=True):
    noisy = perturb(network_of(p), xi, np.random.default_rng(seed), "position")
    noise = noise_model(noisy, "position", xi=xi)
    return posterior(
        noisy, p.stiffness, p.friction, noise, pressure=p.pressure, frictional=frictional
    )  # fmt: skip
