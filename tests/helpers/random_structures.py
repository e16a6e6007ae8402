"""Structures made up from a seed: few freedoms, one to four contacts, often more than freedoms."""

from __future__ import annotations

import numpy as np

import frictionlab as fl


def random_structure(seed: int) -> tuple[fl.Structure, np.ndarray]:
    """A structure and where its motion begins: thrown at its contacts, pressed on them, or at rest.

    Static limits are the friction in slip, so that accelerations are unique.
    """
    rng = np.random.default_rng(seed)
    n, k = int(rng.integers(2, 7)), int(rng.integers(1, 5))
    if rng.random() < 0.3:
        n, k = int(rng.integers(2, 4)), 4
    shape, spring = rng.standard_normal((2, n, n))
    M = np.eye(n) + 0.3 * shape @ shape.T
    K = spring @ spring.T / n * rng.integers(2)
    e, mu = float(rng.choice([0.0, 1.0, rng.random()])), float(rng.choice([0.0, 1.0, rng.random()]))
    impact = (fl.PlasticImpact("full"), fl.RestitutionImpact(e=e), fl.FrictionalImpact(e=e, mu_i=mu), None)
    normal, tangent = rng.standard_normal((2, k, n))
    if rng.random() < 0.3:  # along freedoms, as those of nodes: several contacts rub along one direction
        normal, tangent = np.eye(n)[rng.integers(n, size=k)], np.eye(n)[rng.integers(n, size=k)]
        normal += 1e-3 * rng.standard_normal((k, n))
    v, velocity, start = float(rng.choice([0.0, 0.5, 1.0])), rng.standard_normal(n), rng.integers(3)
    place = 0.3 * rng.standard_normal(n)
    if start == 0:  # all contacts close at 0.3 s, unless forces keep them from it
        normal *= np.where(normal @ velocity < 0.0, -1.0, 1.0)[:, None]
    q = (place - 0.3 * velocity, place, np.zeros(n))[start]
    penetration = (-normal @ place, 0.5, 0.1)[start]
    if start == 1 and v:  # carried along by the counterparts, as far as that goes
        velocity = np.linalg.lstsq(tangent, np.full(k, v))[0]
    contacts = fl.SlidingContacts(
        tangent,
        normal,
        fl.LinearContact(k2=float(rng.choice([1.0, 10.0, 1e3]))),
        fl.Coulomb(mu_k=mu, mu_s=mu),
        v=v,
        impact=impact[rng.integers(4)],
        penetration=penetration,
    )
    load = rng.standard_normal(n) * rng.integers(2)
    return fl.Structure((M + M.T) / 2, (K + K.T) / 2, contacts=contacts, load=load), np.append(q, velocity)
