"""`fl.cea_against_motion`: what eigenvalues say beside what the motion does."""

import numpy as np
import pytest

import frictionlab as fl

QUIET = {"progress": False}
TIMES = {"transient": 20.0, "window": 600.0}


def test_stick_slip_beside_a_stable_equilibrium():
    """A mass on a belt without damping, by hand: it sticks up to mu_s N/k and turns about mu_k N/k."""
    v, drop = 0.1, 0.5
    found = fl.cea_against_motion(fl.MassOnBelt(v=v), "v", [v], "rest", **TIMES, **QUIET)
    assert found.agreement == ("vibrates though stable",)
    assert found.kinds == ("periodic",)
    assert found.amplitudes == pytest.approx([np.hypot(drop, v)], rel=2e-4)
    stick, slip = 2 * drop / v, 2 * np.pi - 2 * np.arctan(drop / v)
    assert found.dominant == pytest.approx([1 / (stick + slip)], rel=1e-4)
    assert fl.cea_against_motion(fl.MassOnBelt(c=0.1), "v", [v], **QUIET).agreement == ("agrees",)


def test_a_structure_without_contacts_rests_where_its_eigenvalues_say():
    coupling = [("mu", [[0.0, 1.0], [-1.0, 0.0]])]
    structure = fl.Structure(
        np.eye(2), np.diag([2.0, 1.0]), 0.05 * np.eye(2), circulatory=coupling, parameters={"mu": 0.1}
    )
    found = fl.cea_against_motion(structure, "mu", [0.1, 0.4], **QUIET)
    assert found.agreement == ("agrees", "agrees")
    assert found.kinds == ("equilibrium", "equilibrium")


@pytest.mark.slow  # it is followed for 500 periods
def test_a_structure_flutters_where_its_eigenvalues_say():
    """Hoffmann et al. (2002): unstable above mu_k = 0.457 without damping; the motion sticks."""
    contacts = fl.SlidingContacts(
        [[1.0, 0.0]], [[0.0, 1.0]], fl.LinearContact(k2=4 / 3), fl.Coulomb(0.3, 1.1)
    )
    springs = [[1.125, 0.21650635], [0.21650635, 0.375]]
    structure = fl.Structure(
        np.eye(2),
        springs,
        0.1 * np.eye(2),
        contacts=contacts,
        load=[("F", [0.0, 1.0])],
        parameters={"F": 5.0},
    )
    found = fl.cea_against_motion(structure, "mu_k", [0.3, 1.0], state="q1", f_max=1.0, **QUIET)
    assert found.agreement == ("agrees", "agrees")
    assert [len(rates) for rates in (found.unstable, found.lines)] == [2, 2]
    assert found.fastest[1] == pytest.approx(fl.eigenvalues(structure.replace(mu_k=1.0)).frequencies.max())
    assert found.amplitudes[0] < 1e-3 < 0.1 < found.amplitudes[1]
    assert found.dominant[1] == pytest.approx(found.fastest[1], rel=0.1)
