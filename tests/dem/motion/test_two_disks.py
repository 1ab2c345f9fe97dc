"""Two disks set up by hand, against closed forms.

Equal disks of mass m meet with approach speed v_n: m_eff = m/2, contact for half a period,
t_c = π √(m_eff/κ).  The closed forms hold for a contact frame at rest; it turns by ~ v t_c/σ
during the contact, so v is small and the tolerance is a multiple of that angle.
"""

from __future__ import annotations

import numpy as np
import pytest

from dem import ContactLaw, Drive, State, step
from dem.model.law import stable_time_step

R = 0.5
MASS = np.pi * R**2
M_EFF = MASS / 2


def meeting(approach: float, sideways: float = 0.0) -> State:
    """Two touching disks on the x axis; the relative velocity of j is (-approach, sideways)."""
    half = 0.5 * np.array([-approach, sideways])
    return State(
        np.array([[-R, 0.0], [R, 0.0]]), np.full(2, R), velocities=np.array([-half, half])
    )


def contact_time(law: ContactLaw) -> float:
    return float(np.pi * np.sqrt(M_EFF / law.stiffness))


def elastic_energy(state: State, law: ContactLaw) -> float:
    overlap = max(0.0, 2 * R - float(np.linalg.norm(np.diff(state.positions, axis=0))))
    u = float(np.sum(state.history.elongations**2))
    return 0.5 * law.stiffness * overlap**2 + 0.5 * law.tangential * u


def test_head_on_collision_is_half_a_period_of_the_spring(backend):
    """Overlap δ(t) = v √(m_eff/κ) sin(π t/t_c); Verlet's error is (ω dt)²/24 in the phase."""
    law, v = ContactLaw(friction=0.0), 1e-3
    steps = 400
    dt = contact_time(law) / steps
    state = meeting(v)
    for k in range(1, steps):
        step(state, law, dt, backend=backend)
        overlap = 2 * R - np.linalg.norm(np.diff(state.positions, axis=0))
        exact = v * np.sqrt(M_EFF) * np.sin(np.pi * k / steps)
        assert overlap == pytest.approx(exact, abs=v * np.sqrt(M_EFF) * (np.pi / steps) ** 2)
    step(state, law, dt, steps=steps // 10, backend=backend)
    swapped = meeting(-v).velocities
    assert np.abs(state.velocities - swapped).max() <= v * (np.pi / steps) ** 2


@pytest.mark.parametrize("speed", [1e-3, 1e-4])
def test_oblique_gross_sliding_takes_the_coulomb_impulse(backend, speed):
    """Sliding throughout: J_n = 2 m_eff v_n, J_t = μ J_n, each disk spins up by R J_t/I."""
    mu, law = 0.1, ContactLaw(friction=0.1, stiffness_ratio=1.0)
    state = meeting(speed, sideways=3 * speed)
    steps = 4000
    step(state, law, 1.1 * contact_time(law) / steps, steps=steps, backend=backend)
    impulse = 2 * M_EFF * speed
    # j moves up, so f_t > 0: i is dragged up, j down, and both turn counter-clockwise.
    along, across = state.velocities[1] * MASS
    turned = 3 * speed * contact_time(law) / (2 * R)  # angle swept by the contact frame
    # The first and last instants, where μ f_n < k_t u, stick: a share ~ μ of the impulse's ends.
    tolerance = 5 * impulse * (turned + np.pi / steps)
    assert along == pytest.approx(-0.5 * MASS * speed + impulse, abs=tolerance)
    assert across == pytest.approx(1.5 * MASS * speed - mu * impulse, abs=tolerance)
    spin = R * mu * impulse / (0.5 * MASS * R**2)
    assert state.spins == pytest.approx([spin, spin], abs=tolerance * 2 / (MASS * R))


def test_sticking_contact_swings_on_the_tangential_spring(backend):
    """u = (v_t/ω_t) sin ω_t t, ω_t² = 3 k_t/m_eff: rotation makes a disk 3 times lighter.

    Corrections: the overlap over σ (lever arm R against r/2) and the phase error of Verlet.
    """
    law, v = ContactLaw(friction=1e3, stiffness_ratio=0.3), 1e-5
    steps = 2000
    dt = contact_time(law) / steps
    omega = np.sqrt(3 * law.tangential / M_EFF)
    state = meeting(v, sideways=0.1 * v)
    for k in range(1, 20):
        step(state, law, dt, steps=steps // 20, backend=backend)
        t = k * (steps // 20) * dt
        u = float(state.history.elongations.sum())
        exact = 0.1 * v / omega * np.sin(omega * t)
        overlap = v * np.sqrt(M_EFF) / (2 * R)
        assert u == pytest.approx(exact, abs=0.1 * v / omega * (overlap + (omega * dt) ** 2))


def energy_error(law: ContactLaw, steps: int, backend: str) -> float:
    """Largest relative change of the energy while two disks collide obliquely and stick.

    Over 4/5 of the contact: at its very end f_n vanishes before f_t, and every contact slides.
    """
    state = meeting(0.05, sideways=0.03)
    dt = contact_time(law) / steps
    start, worst = state.kinetic_energy, 0.0
    for _ in range(4 * steps // 5):
        step(state, law, dt, backend=backend)
        worst = max(worst, abs(state.kinetic_energy + elastic_energy(state, law) - start))
    return worst / start


@pytest.mark.parametrize("friction", [0.0, 1e3])
def test_energy_error_is_of_second_order_in_the_time_step(backend, friction):
    """No damping, no sliding: slope 2 in dt over a factor 16, ± 0.15 for the next order."""
    law = ContactLaw(friction=friction)
    counts = np.array([25, 50, 100, 200, 400])
    errors = [energy_error(law, int(n), backend) for n in counts]
    slope = -np.polyfit(np.log(counts), np.log(errors), 1)[0]
    assert slope == pytest.approx(2.0, abs=0.15)


def test_sliding_dissipates(backend):
    """The negative control of energy conservation: a slider loses what the drag does not."""
    assert energy_error(ContactLaw(friction=0.1), 200, backend) > 0.01


def test_dashpot_gives_the_coefficient_of_restitution(backend):
    """Force never attractive: e = exp(-β/ω (π - atan(2βω/(ω²-β²)))), β = c/2m_eff, ω² = ω0²-β²
    (Schwager & Pöschel, Granular Matter 9, 465 (2007))."""
    beta = 0.2 * np.sqrt(1 / M_EFF)
    omega = np.sqrt(1 / M_EFF - beta**2)
    law = ContactLaw(friction=0.0, dashpot=2 * beta * M_EFF)
    exact = np.exp(-beta / omega * (np.pi - np.arctan2(2 * beta * omega, omega**2 - beta**2)))
    v, steps = 1e-3, 4000
    state = meeting(v)
    step(state, law, 1.5 * contact_time(law) / steps, steps=steps, backend=backend)
    restitution = (state.velocities[1, 0] - state.velocities[0, 0]) / v
    # The dashpot acts on the velocity half a step ago: first order in dt.
    assert restitution == pytest.approx(exact, abs=2 * np.pi / steps)


def test_drag_fades_a_free_grain_exponentially(backend):
    """v = v0 exp(-γ t), to the (γ dt)²/12 of the trapezoidal rule."""
    state = State(
        np.zeros((1, 2)), np.ones(1), velocities=np.array([[1.0, -2.0]]), spins=np.array([3.0])
    )
    gamma, dt, steps = 0.5, 0.01, 200
    step(state, ContactLaw(), dt, drive=Drive(drag=gamma), steps=steps, backend=backend)
    fade = np.exp(-gamma * dt * steps)
    band = (gamma * dt) ** 2 / 12 * gamma * dt * steps * 2
    assert state.velocities[0] == pytest.approx(np.array([1.0, -2.0]) * fade, rel=band)
    assert state.spins[0] == pytest.approx(3.0 * fade, rel=band)


def test_angular_momentum_holds_to_the_overlap(backend):
    """Torques R f_t on both, forces r apart: dL/dt = (σ - r) f_t, so L drifts by O(overlap)."""

    def angular_momentum(state: State) -> float:
        x, v = state.positions, state.velocities
        orbital = MASS * np.sum(x[:, 0] * v[:, 1] - x[:, 1] * v[:, 0])
        return float(orbital + 0.5 * MASS * R**2 * state.spins.sum())

    drifts = []
    for v in (1e-2, 1e-3):
        law, state = ContactLaw(friction=1e3), meeting(v, sideways=v)
        start = angular_momentum(state)
        step(state, law, contact_time(law) / 500, steps=520, backend=backend)
        drifts.append(abs(angular_momentum(state) / start - 1))
        assert drifts[-1] < v * np.sqrt(M_EFF) / (2 * R)  # largest overlap over σ
    assert drifts[1] / drifts[0] == pytest.approx(0.1, rel=0.3)


def test_time_step_of_the_docs_resolves_the_contact():
    """dt = 0.2 √(m_eff/κ): 16 steps a collision."""
    law = ContactLaw()
    assert contact_time(law) / stable_time_step(law, MASS, 0.2) == pytest.approx(5 * np.pi)
