"""A rod of 100 finite elements, 200 states: closed forms, and a run beside another integrator."""

import numpy as np
from scipy.integrate import solve_ivp

import frictionlab as fl
from chain_and_rod import rod, rod_matrices
from frictionlab.stability.equilibrium_points.equilibria import equilibrium_problem
from frictionlab.stability.flow import Flow


def test_natural_frequencies_are_those_of_the_elements_in_closed_form():
    model = rod(200).replace(c=0.0)
    n, h = model.elements, model.length / model.elements
    angles = (2 * np.arange(1, n + 1) - 1) * np.pi / (2 * n)
    squares = model.E / model.rho * 6 / h**2 * (1 - np.cos(angles)) / (2 + np.cos(angles))
    found = np.sort(fl.eigenvalues(model).values.imag)[n:]
    np.testing.assert_allclose(found, np.sqrt(squares), rtol=1e-8)
    first = np.pi / 2 * np.sqrt(model.E / model.rho) / model.length  # of the rod itself
    assert abs(found[0] / first - 1) < 1e-4


def test_the_rod_slips_at_the_elongation_of_its_friction():
    model = rod(200)
    at = np.arange(1, model.elements + 1) / model.elements
    stretched = model.friction.mu_k * model.N * model.length / (model.E * model.area)
    np.testing.assert_allclose(fl.equilibrium(model).q, stretched * at, rtol=1e-10)


def test_stick_and_slip_of_100_states_beside_another_integrator():
    """DOP853 on numpy's matrices, from event to event."""
    model, t_end = rod(100), 6e-4
    run = fl.simulate(model, t_end, x0=np.zeros(100), progress=False)
    assert {"stick", "slip+"} <= {*run.mode}
    assert len(run.events) >= 2
    state, t = np.zeros(100), 0.0
    for mode, end in zip([run.mode[0], *run.events.target], [*run.events.t, t_end], strict=True):
        found = solve_ivp(
            rates_of(model, mode), (t, end), state, "DOP853", rtol=1e-12, atol=1e-16 * np.ones(100)
        )
        state, t = found.y[:, -1], end
    size = np.repeat([np.abs(run.final_state[:50]).max(), np.abs(run.final_state[50:]).max()], 50)
    np.testing.assert_allclose(run.final_state / size, state / size, atol=1e-7)


def rates_of(model, mode):
    """The rates of a rod by its matrices; in stick its last node has the belt's speed."""
    n = model.elements
    mass, stiffness = rod_matrices(n, model.length / n)
    stiffness *= model.E * model.area
    held = np.eye(n)[-1] if mode == "stick" else np.zeros(n)
    friction = {"stick": 0.0, "slip+": 1.0, "slip-": -1.0}[mode] * model.friction.mu_k * model.N
    bordered = np.block([[model.rho * model.area * mass, -held[:, None]], [held[None], 1.0 - held.sum()]])
    matrix = np.linalg.inv(bordered)

    def rates(t, state):
        forces = -stiffness @ (state[:n] + model.c * state[n:])
        forces[-1] += friction
        return np.hstack([state[n:], (matrix @ np.append(forces, 0.0))[:n]])

    return rates


def test_an_equilibrium_of_200_states_is_followed_in_a_few_steps(monkeypatch):
    """The rounding of such an elimination is more than that of a state: steps that no longer shrink are the
    last.
    """
    model = rod(200)
    problem = equilibrium_problem(model)
    jacobian, steps = Flow.jacobian, []

    def counted(flow, x, values):
        steps.append(x.shape)
        return jacobian(flow, x, values)

    monkeypatch.setattr(Flow, "jacobian", counted)
    loads = np.array([0.5, 1.0, 2.0]) * model.N
    found = problem.linearised({"N": loads})[0]
    at = np.arange(1, model.elements + 1) / model.elements
    stretched = model.friction.mu_k * loads * model.length / (model.E * model.area)
    np.testing.assert_allclose(found[: model.elements], stretched * at[:, None], rtol=1e-10)
    assert 0 < len(steps) <= 12  # 42 where they go on at random; rounding decides on one more or less
