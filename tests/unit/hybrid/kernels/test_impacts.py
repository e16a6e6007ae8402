"""Impacts at one instant: rows of balls against closed forms, and against balls with small gaps.

The latter are walked from one collision to the next.
"""

from functools import cache
from itertools import pairwise

import numpy as np
import pytest

import frictionlab as fl
from frictionlab.models import Mechanics, Stop
from tests.helpers.cases import slow_but


@cache
def row(masses, restitutions, wall=None, order=None, push=0.0):
    """Balls in a row on a line, and a wall to their right at 0; contacts in any order."""
    names = tuple(f"x{i}" for i in range(len(masses)))

    @fl.model
    class Row(fl.MechanicalModel):
        """Balls of no radius: they touch where their coordinates are equal."""

        push: float = fl.parameter(0.0, unit="N", symbol="F", meaning="force to the right", range=(0.0, 1.0))
        impact: fl.ImpactLaw = fl.RestitutionImpact(e=1.0)
        coordinates = names

        def mechanics(self, q, v):
            distances = [b - a for a, b in pairwise(q)] + ([-q[-1]] if wall is not None else [])
            laws = [fl.RestitutionImpact(e=e) for e in (*restitutions, *([] if wall is None else [wall]))]
            stops = [Stop(one, law) for one, law in zip(distances, laws, strict=True)]
            return Mechanics(
                kinetic=sum(m * u**2 for m, u in zip(masses, v)) / 2,
                potential=-self.push * q[-1],
                contacts=tuple(stops[i] for i in order or range(len(stops))),
            )

    return Row(push=push)


def after(model, x, v, t_end=3.0):
    run = fl.simulate(model, t_end, x0=np.array([*x, *v], dtype=float), progress=False)
    assert run.status is fl.Status.FINISHED
    return run, run.final_state[len(x) :]


def strike(count, masses=None, e=1.0, wall=None, **more):
    """The first ball hits others that touch, and the wall if there is one: velocities after all."""
    masses = tuple(masses or [1.0] * count)
    model = row(masses, (e,) * (count - 1), wall, **more)
    return after(model, [-1.0] + [0.0] * (count - 1), [1.0] + [0.0] * (count - 1))


def walk(masses, restitutions, wall, gaps, v, most=10_000):
    """Velocities after all collisions of balls with gaps, from one collision to the next."""
    v, gaps, masses = list(v), list(gaps), [*masses, np.inf]
    v, e = [*v, *([0.0] if wall is not None else [])], [*restitutions, *([] if wall is None else [wall])]
    for _ in range(most):
        times = [g / (v[i] - v[i + 1]) if v[i] > v[i + 1] else np.inf for i, g in enumerate(gaps)]
        i = int(np.argmin(times))
        if times[i] == np.inf:
            return v[: len(masses) - 1]
        gaps = [max(g + times[i] * (v[k + 1] - v[k]), 0.0) for k, g in enumerate(gaps)]
        gaps[i] = 0.0
        one, other = masses[i], masses[i + 1]
        share = 0.0 if other == np.inf else one / (one + other)
        jump = (1 + e[i]) * (v[i] - v[i + 1])
        v[i], v[i + 1] = v[i] - (1 - share) * jump, v[i + 1] + share * jump
    raise AssertionError("collisions without end")


@pytest.mark.parametrize("count", slow_but([2, 3, 5], [2, 3, 5, 6]))
def test_newtons_cradle(count):
    """The last ball takes the velocity of the first; with two balls in, two go out."""
    run, v = strike(count)
    assert v == pytest.approx([0.0] * (count - 1) + [1.0], abs=1e-14)
    assert run.events.t == pytest.approx([1.0] * (count - 1), abs=1e-15)
    model = row((1.0,) * count, (1.0,) * (count - 1))
    two = after(model, [-1.0, -1.0] + [0.0] * (count - 2), [1.0, 1.0] + [0.0] * (count - 2))[1]
    assert two == pytest.approx([0.0] * (count - 2) + [1.0, 1.0], abs=1e-14)


def test_an_impact_with_the_rate_of_a_rounding_error_waits_for_a_great_one():
    """The last ball of a cradle on strings comes back; the others stand still but for 1e-33 m/s."""

    @fl.model
    class Cradle(fl.MechanicalModel):
        """Five equal balls on strings of one length, which touch at rest."""

        impact: fl.ImpactLaw = fl.RestitutionImpact(e=1.0)
        coordinates = tuple(f"x{i}" for i in range(5))

        def mechanics(self, q, v):
            stops = tuple(Stop(b - a, self.impact) for a, b in pairwise(q))
            return Mechanics(sum(u**2 for u in v) / 2, sum(x**2 for x in q) / 2, contacts=stops)

    start = [-0.2, *[0.0] * 9]
    run = fl.simulate(Cradle(), 2.25 * np.pi, x0=start, progress=False)
    assert run.status.ok
    assert run.q[-1] == pytest.approx([-0.2 * np.cos(np.pi / 4), 0.0, 0.0, 0.0, 0.0], abs=1e-12)


@pytest.mark.parametrize("ratio", [0.3, 1.0, 3.0, 100.0, 1e4])
def test_a_ball_between_a_ball_and_a_wall(ratio):
    """With e = 1 the angle atan2(v2, sqrt(ratio) v1) turns by 2 atan(1/sqrt(ratio)) in two impacts.

    So there are 31 impacts at a ratio of 100 and 314 at 1e4, the digits of pi, whether the ball rests at the
    wall, is pressed on it, or is a little away.
    """
    angle = np.arctan(1 / np.sqrt(ratio))
    impacts = int(np.ceil(np.pi / angle)) - 1
    turned = angle * 2 * ((impacts + 1) // 2)
    sign = 1.0 if impacts % 2 == 0 else -1.0
    expected = [np.cos(turned), -sign * np.sqrt(ratio) * np.sin(turned)]
    walked = walk((ratio, 1.0), (1.0,), 1.0, (1.0, 1e-9), (1.0, 0.0))
    assert walked == pytest.approx(expected, abs=1e-10)
    run, v = strike(2, (ratio, 1.0), wall=1.0)
    assert v == pytest.approx(expected, abs=1e-11)
    assert len(run.events) == impacts
    pressed = after(row((ratio, 1.0), (1.0,), 1.0, push=1e-3), [-1.0, 0.0], [1.0, 0.0], 1.0 + 1e-9)[1]
    assert pressed == pytest.approx(expected, abs=1e-9)
    near = after(row((ratio, 1.0), (1.0,), 1.0), [-1.0, -1e-14], [1.0, 0.0])[1]
    assert near == pytest.approx(expected, abs=1e-9)


@pytest.mark.parametrize("seed", slow_but(range(3), range(6)))
def test_the_limit_of_small_gaps(seed):
    """Of two contacts that take turns; e from just above where the impacts would not end."""
    rng = np.random.default_rng(seed)
    masses, e = tuple(rng.uniform(0.2, 5.0, 3)), tuple(rng.uniform(0.6, 1.0, 2))
    walked = walk(masses, e, None, (1.0, 1e-7), (1.0, 0.0, 0.0))
    assert after(row(masses, e), [-1.0, 0.0, 0.0], [1.0, 0.0, 0.0])[1] == pytest.approx(walked, abs=1e-13)
    walked = walk(masses[:2], e[:1], e[1], (1.0, 1e-7), (1.0, 0.0))
    against_wall = row(masses[:2], e[:1], e[1])
    assert after(against_wall, [-1.0, 0.0], [1.0, 0.0], 1.01)[1] == pytest.approx(walked, abs=1e-12)


@pytest.mark.parametrize("seed", slow_but([1], range(4)))
def test_energy_never_grows_and_the_order_of_contacts_does_not_matter(seed):
    """Balls that all meet at one instant."""
    rng = np.random.default_rng(seed)
    count = 5
    masses, v = rng.uniform(0.2, 5.0, count), -np.sort(rng.normal(size=count))
    for e in ((1.0,) * 4, tuple(rng.uniform(0.0, 1.0, 4))):
        run, found = after(row(tuple(masses), e), -v, v, 1.0 + 1e-9)
        energies = 0.5 * (run.events.state[:, count:] ** 2 @ masses)
        assert (np.diff(energies, prepend=0.5 * v**2 @ masses) < 1e-12).all()
        assert masses @ found == pytest.approx(masses @ v, abs=1e-12)
        if min(e) == 1.0:
            assert 0.5 * found**2 @ masses == pytest.approx(0.5 * v**2 @ masses, rel=1e-12)
        order = tuple(rng.permutation(4).tolist())
        assert after(row(tuple(masses), e, None, order), -v, v, 1.0 + 1e-9)[1] == pytest.approx(
            found, abs=1e-11
        )


@pytest.mark.parametrize("e", [1.0, 0.7])
@pytest.mark.parametrize("order", [None, (1, 0)])
def test_equal_impacts_act_together(e, order):
    """Two balls hit one between them: it stays, and they go back by Newton's law."""
    run, v = after(row((1.0, 2.0, 1.0), (e, e), None, order), [-1.0, 0.0, 1.0], [1.0, 0.0, -1.0])
    assert v == pytest.approx([-e, 0.0, e], abs=1e-14)
    assert sorted(run.events.guard) == ["impact_1", "impact_2"]


@pytest.mark.parametrize("e", [0.0, 0.02, 0.06])
def test_impacts_without_end_have_their_limit(e):
    """Below e = 7 - 4 sqrt(3) = 0.0718 three equal balls stay together, and two come to rest at a wall."""
    run, v = strike(3, e=e)
    assert v == pytest.approx([1 / 3] * 3, abs=1e-14)
    assert run.stats["accumulations"] == 1
    assert np.abs(strike(2, e=e, wall=e)[1]).max() < 1e-14
    # With gaps the impacts have the same end in time.
    apart = after(row((1.0,) * 3, (e,) * 2), [-1.0, 0.0, 1e-3], [1.0, 0.0, 0.0], 5.0)[1]
    assert apart == pytest.approx([1 / 3] * 3, abs=1e-10)


def test_a_stack_comes_to_rest():
    """Two balls on a floor, which hit each other and it: in the end both rest."""

    @fl.model
    class Stack(fl.MechanicalModel):
        """A ball above another."""

        impact: fl.ImpactLaw = fl.RestitutionImpact(e=0.5)
        coordinates = ("low", "high")

        def mechanics(self, q, v):
            return Mechanics(
                kinetic=v.low**2 / 2 + v.high**2,
                potential=9.81 * (q.low + 2 * q.high),
                contacts=(Stop(q.low, self.impact), Stop(q.high - q.low, self.impact)),
            )

    for start in ([1.0, 1.2, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [1.0, 1.0, 0.0, 0.0]):
        run = fl.simulate(Stack(), 8.0, x0=np.array(start), progress=False)
        assert run.mode[-1] == "contact | contact"
        assert np.abs(run.final_state).max() < 1e-12


@fl.model
class BallInABox(fl.MechanicalModel):
    """A ball on a spring between a floor and a ceiling."""

    e: float = 0.8
    g: float = 10.0
    k: float = 0.0
    height: float = 1.5
    coordinates = ("x",)

    def mechanics(self, q, v):
        law = fl.RestitutionImpact(e=self.e)
        stops = Stop(q.x, law), Stop(self.height - q.x, law)
        return Mechanics(v.x**2 / 2, self.g * q.x + self.k * q.x**2 / 2, contacts=stops)


@pytest.mark.parametrize(
    ("ball", "v", "published"),
    [
        (
            BallInABox(),  # BouncingBallED-TwoContacts: rows t, x, v
            10.0,
            [
                [0.5, 1.357781774917158, -4.418746937951609],
                [2.0, 0.5866346313569701, 2.718056031221656],
                [4.0, 0.06572727044458226, 1.922962429366541],
                [6.0, 0.002473958861317242, -0.09115400281828512],
                [9.0, 0.0, 0.0],
            ],
        ),
        (
            BallInABox(e=0.9, g=9.81, k=1e5),  # LinearOscillatorED
            0.0,
            [[0.5, 0.0008086143034453319, -1.604808493738425], [3.0, 0.0, 0.0]],
        ),
    ],
)
def test_a_ball_moves_as_in_published_runs_of_siconos(ball, v, published):
    """Event-driven examples of siconos-tutorials (V. Acary, F. Perignon 2021), by LSODAR and LCPs."""
    t, x, velocity = np.transpose(published)
    run = fl.simulate(ball, t[-1], x0=[1.0, v], progress=False)
    np.testing.assert_allclose(run(t), np.column_stack([x, velocity]), atol=1e-10)
    assert run.mode[-1].split(" | ")[0] == "contact"


def column(count, e):
    """Beads of no height above each other and a floor."""

    @fl.model
    class Column(fl.MechanicalModel):
        """Beads and their distances."""

        impact: fl.ImpactLaw = fl.RestitutionImpact(e=e)
        coordinates = tuple(f"z{i}" for i in range(count))

        def mechanics(self, q, v):
            distances = [q[0], *(b - a for a, b in pairwise(q))]
            stops = tuple(Stop(one, self.impact) for one in distances)
            return Mechanics(sum(u**2 for u in v) / 2, 9.81 * sum(q), contacts=stops)

    return Column()


@pytest.mark.parametrize("count", slow_but([4], [4, 10]))
def test_beads_that_touch_fall_and_rise_as_one(count):
    """BeadColumnED_NewtonLaw of siconos-tutorials: ten beads, elastic, 50 mm above the floor."""
    run = fl.simulate(column(count, 1.0), 0.492, x0=[0.05] * count + [0.0] * count, progress=False)
    np.testing.assert_allclose(run.q[-1], 0.01689042018940357 - 0.005, atol=1e-13)
    np.testing.assert_allclose(run.v[-1], -0.8647022353873588, atol=1e-12)
    assert len(run.events) == count * (count + 1)  # half of them at each of two falls


@pytest.mark.slow(reason="ten balls: some dozens of modes are derived")
def test_a_column_of_beads_moves_from_impact_to_impact():
    """The tutorial of Siconos: ten beads 1 m apart, the lowest 10.4 m above the floor, e = 0.9.

    Between impacts distances of beads are linear in time, and that from the floor is a parabola.
    """
    e, g, t_end = 0.9, 9.81, 4.0
    z, v, t, impacts = 10.4 + np.arange(10.0), np.zeros(10), 0.0, []
    run = fl.simulate(column(10, e), t_end, x0=np.concatenate([z, v]), progress=False)
    while True:
        gaps, closing = np.diff(z), -np.diff(v)
        waits = np.where(closing > 1e-12, np.maximum(gaps, 0.0) / np.maximum(closing, 1e-12), np.inf)
        floor = (v[0] + np.sqrt(v[0] ** 2 + 2 * g * max(z[0], 0.0))) / g if z[0] > 1e-12 or v[0] > 0 else 0.0
        i = int(np.argmin([floor, *waits]))
        wait = min([floor, *waits][i], t_end - t)
        z, v, t = z + wait * v - g * wait**2 / 2, v - g * wait, t + wait
        if t >= t_end:
            break
        impacts.append(t)
        if i == 0:
            z[0], v[0] = 0.0, -e * v[0]
        else:
            mean, half = (v[i - 1] + v[i]) / 2, (v[i - 1] - v[i]) / 2
            v[i - 1], v[i] = mean - e * half, mean + e * half
    assert len(impacts) > 50
    np.testing.assert_allclose(run.events.t, impacts, atol=1e-9)
    np.testing.assert_allclose(run.final_state, [*z, *v], atol=1e-8)
