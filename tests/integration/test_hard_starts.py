"""Starts and parameters at which a solver of contact with friction stumbles."""

import numpy as np
import pytest

import frictionlab as fl
from frictionlab.components import SlidingOnly
from tests.helpers.assertions import assert_all, assert_same_times

FULL = fl.PlasticImpact("full")
MODEL = fl.SliderOnBelt(mu_k=1.4, impact=FULL)
BOTH = [MODEL, MODEL.without("geometry")]


def ids(model):
    return f"{len(model.coordinates)} dof"


def at(model, **values):
    """A state, zero but for what is given by name; rates as x1_ for x1'."""
    names = [*model.coordinates, *(f"{name}_" for name in model.coordinates)]
    state = np.zeros(len(names))
    for name, value in values.items():
        state[names.index(name)] = value
    return state


def motion(model, t_end=1.0, **options):
    run = fl.simulate(model, t_end, **options)
    assert run.status is fl.Status.FINISHED
    assert np.isfinite(run.states).all()
    assert (np.diff(run.events.t) >= 0).all()
    return run


@pytest.mark.parametrize("model", BOTH, ids=ids)
def test_resting_on_the_belt_at_penetration_zero_starts_in_contact(model):
    """Penetration and its rate are 0, its second derivative is F/M: the second coefficient decides."""
    run = motion(model, x0="rest")
    assert run.mode[0] == "slip+"
    assert run.penetration[0] == 0.0
    assert run.events.t[0] > 0.01


@pytest.mark.parametrize("model", BOTH, ids=ids)
def test_without_preload_nothing_moves_from_rest_but_the_belt_underneath(model):
    """The penetration vanishes identically: no guard ends the mode, and F_N stays zero."""
    run = motion(model.replace(F=0.0), x0="rest")
    assert len(run.events) == 0
    assert np.abs(run.states).max() == 0.0


def test_a_negative_preload_is_not_needed_to_lift_off():
    state = at(MODEL, y1_=0.5)
    run = motion(MODEL, x0=state)
    assert run.mode[0] == "separation"
    assert (run.events.guard == "gap").any()


def test_a_start_in_flight():
    run = motion(MODEL, x0=at(MODEL, y1=0.01))
    assert run.mode[0] == "separation"
    assert run.penetration[0] == -0.01
    assert run.events.source[0] == "separation"
    landing = run.events.before[0]
    assert landing[3] - (landing[0] - landing[2]) * landing[4] - landing[1] == pytest.approx(0.0, abs=1e-15)


@pytest.mark.parametrize("model", BOTH, ids=ids)
@pytest.mark.parametrize("rate", [0.3, 0.0, -0.3])
def test_gap_and_relative_velocity_zero_at_once(model, rate):
    """x1' = v on the belt, the gap opening, resting or closing."""
    run = motion(model, x0=at(model, x1_=model.v, y1_=rate))
    if rate > 0:
        assert run.mode[0] == "separation"
    elif rate < 0:
        assert run.mode[0] in ("stick", "slip+", "slip-")
        assert run.normal_force[1] > 0
    assert run.relative_velocity[0] == 0.0


def stick_at_the_limit(sign):
    """A state in stick with |F_T| = mu_s F_N to the last bit, and the model it belongs to.

    All values are dyadic, so the tape computes the guard without rounding error.
    """
    model = fl.SliderOnBelt(
        mu_k=0.5, mu_s=1.0, F=0.0, v=1.0, k_nl=0.0, k1=8192.0, k2=4096.0, k3=0.0, k4=8192.0, c1=0.0, c4=0.0
    ).without("geometry")
    penetration = 2.0**-6  # F_N = 64; F_T = (M r2 - m r1)/(M + m) = (k1 x1 - k4 x2)/2
    x1 = sign * 64.0 * 2 / 8192.0
    return model, at(model, x1=x1, y1=-penetration, x1_=1.0, x2_=0.0)


@pytest.mark.parametrize("sign", [1, -1])
def test_stick_exactly_at_the_limit(sign):
    model, state = stick_at_the_limit(sign)
    held = fl.simulate(model, 1e-9, x0=state)
    assert held.relative_velocity[0] == 0.0
    assert held.normal_force[0] == 64.0
    # x1 grows at the belt's speed: beyond +mu_s F_N the limit is passed at once, at -mu_s F_N left behind.
    assert held.mode[0] == ("slip+" if sign > 0 else "stick")
    run = motion(model, 0.5, x0=state)
    sticking = run.mode == "stick"
    assert sticking.any() == (sign < 0)  # in this time
    assert (np.abs(run.friction_force) <= run.normal_force * (1 + 1e-12) + 1e-9)[sticking].all()


@pytest.mark.parametrize("distance", [1e-9, 1e-13])
def test_beyond_a_limit_that_is_left_behind_friction_drops_to_the_kinetic(distance):
    model, state = stick_at_the_limit(-1)
    state[0] *= 1 + distance
    assert motion(model, 0.2, x0=state).mode[0] == "slip-"


@pytest.mark.parametrize(
    ("sign", "distance"), [(1, 1e-9), (1, 1e-13), (1, -1e-13), (1, -1e-9), (-1, -1e-13), (-1, -1e-9)]
)
def test_stick_near_the_limit_is_consistent(sign, distance):
    model, state = stick_at_the_limit(sign)
    state[0] *= 1 + distance
    exact = motion(model, 0.2, x0=stick_at_the_limit(sign)[1])
    assert motion(model, 0.2, x0=state).final_state == pytest.approx(exact.final_state, abs=1e-6)


@pytest.mark.parametrize(
    "change",
    [
        {"mu_k": 1.4, "mu_s": 1.4},
        {"mu_k": 3.0, "mu_s": 3.0},
        {"mu_k": 0.0, "mu_s": 0.0},
        {"mu_k": 0.0},
        {"v": 0.0},
        {"v": -1.0},
        {"v": -1e-300},
        {"F": 0.0},
        {"F": 1e-12},
        {"k_nl": 0.0},
        {"k_nl": 1e10},
        {"k3": 0.0},
        {"l1": 0.0, "l2": 0.0},
        {"c1": 0.0, "c2": 0.0, "c4": 0.0, "c5": 0.0, "c6": 0.0},
    ],
    ids=str,
)
@pytest.mark.parametrize("model", [*BOTH, fl.SliderOnBelt(mu_k=1.4)], ids=["full", "fixed", "material"])
@pytest.mark.parametrize("x0", ["rest", "stick", "flight"])
def test_limits_of_the_parameters_are_no_special_cases(model, change, x0):
    model = model.replace(**change)
    states = {"rest": {}, "flight": {"y1": 1e-3}, "stick": {"x1_": model.v, "y1": -0.02}}
    run = motion(model, 0.5, x0=at(model, **states[x0]))
    if x0 == "stick" and model.mu_s > model.mu_k:
        assert run.mode[0] == "stick"
    assert_all(run.normal_force[run.mode != "separation"] >= -1e-6)


def test_endless_micro_flights_reach_the_cap_and_say_so():
    """Without preload Eq. (13) gives flights of 1e-8 s, a million of them, while phi tends to zero."""
    model = fl.SliderOnBelt(mu_k=1.4, F=0.0)
    run = fl.simulate(model, 0.5, x0=at(model, y1=1e-3), method=fl.Taylor(chatter=0.0, max_events=5000))
    assert run.status is fl.Status.EVENT_CAP
    assert run.t[-1] > 0.26
    flights = np.diff(run.events.t)[100:]
    assert (flights > 1e-9).all()
    assert (flights < 1e-7).all()
    assert (np.diff(flights) < 0).all()


def test_the_other_way_round_is_the_mirror_image():
    """v < 0 mirrors x1, x2, phi where the 45-degree spring, which is not symmetric, is absent."""
    model = MODEL.replace(k3=0.0)
    there, back = motion(model), motion(model.replace(v=-1.0))
    mirror = np.array([-1, 1, -1, 1, -1] * 2)
    assert_same_times(back.events.t, there.events.t, abs=1e-13)
    assert back.final_state == pytest.approx(mirror * there.final_state, abs=1e-10)
    swap = {"slip+": "slip-", "slip-": "slip+"}
    assert back.events.target.tolist() == [swap.get(mode, mode) for mode in there.events.target]


@pytest.mark.parametrize("interface", [SlidingOnly(), fl.StickSlipSeparation()], ids=["smooth", "non-smooth"])
@pytest.mark.parametrize("k_nl", [0.0, 1e4, 1e7])
def test_energy_without_damping_and_friction_is_conserved(k_nl, interface):
    """No loss while the contact lasts: small motions about the equilibrium, for 10 s."""
    model = fl.SliderOnBelt(mu_k=0.0, k_nl=k_nl, c1=0, c2=0, c4=0, c5=0, c6=0, interface=interface)
    model = model.without("geometry")
    if interface == fl.StickSlipSeparation():
        model = model.replace(mu_s=0.0)
    start = at(model)
    start[:4] = fl.equilibrium(model).q * 1.05
    run = motion(model, 10.0, x0=start)
    assert "separation" not in run.mode
    names = (*model.coordinates, *(f"{name}'" for name in model.coordinates))
    x1, y1, x2, y2, *rates = (run[name] for name in names)
    p = model.parameters
    kinetic = (p["M"] * (rates[0] ** 2 + rates[1] ** 2) + p["m"] * (rates[2] ** 2 + rates[3] ** 2)) / 2
    springs = p["k1"] * x1**2 + p["k3"] * (x1 - y1) ** 2 / 2 + p["k4"] * x2**2 + (p["k5"] + p["k6"]) * y2**2
    contact = p["k2"] * run.penetration**2 / 2 + p["k_nl"] * run.penetration**4 / 4
    energy = kinetic + springs / 2 + contact + p["F"] * y1
    assert np.ptp(energy) <= 1e-10 * np.abs(energy).max()


@pytest.mark.parametrize("model", BOTH, ids=ids)
@pytest.mark.parametrize("part", np.linspace(0.05, 0.95, 7))
def test_a_run_can_be_stopped_and_taken_up_again(model, part):
    whole = motion(model, 2.0)
    first = motion(model, 2.0 * part)
    mode = str(first.mode[-1])
    second = fl.solve(model.automaton(), 2.0 - 2.0 * part, x0=first.final_state, mode=mode)
    times = np.concatenate([first.events.t, 2.0 * part + second.events.t])
    assert [*first.events.target, *second.events.target] == whole.events.target.tolist()
    assert_same_times(times, whole.events.t, abs=1e-10)
    assert second.final_state == pytest.approx(whole.final_state, abs=1e-9)
