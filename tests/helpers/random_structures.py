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


def degenerate_structure(seed: int) -> tuple[fl.Structure, np.ndarray]:
    """A structure of two to six freedoms on two to twelve contacts, all coordinates 0, and its start.

    All contacts close, or some, or all is at rest.  Rows may be parallel, or span fewer directions than there
    are freedoms.
    """
    rng = np.random.default_rng(seed)
    n, k = int(rng.integers(2, 7)), int(rng.integers(2, 13))
    if rng.random() < 0.4:
        n = int(rng.integers(2, 4))
    shape, spring = rng.standard_normal((2, n, n))
    M = np.eye(n) + 0.3 * shape @ shape.T * rng.integers(2)
    K = spring @ spring.T / n * rng.integers(2)
    e, mu = float(rng.choice([0.0, 1.0, rng.random()])), float(rng.choice([0.0, 1.0, rng.random()]))
    impact = (fl.PlasticImpact("full"), fl.RestitutionImpact(e=e), fl.FrictionalImpact(e=e, mu_i=mu), None)
    impact = impact[rng.integers(4)]
    normal, tangent = rng.standard_normal((2, k, n))
    kind, fewer = rng.integers(4), max(1, n - 1)
    if kind == 1:
        normal, tangent = np.eye(n)[rng.integers(n, size=k)], np.eye(n)[rng.integers(n, size=k)]
        normal = normal * rng.uniform(0.5, 2, (k, 1))
    elif kind == 2:
        normal, tangent = rng.integers(-1, 2, (k, n)).astype(float), rng.integers(-1, 2, (k, n)).astype(float)
        normal[~normal.any(1), 0] = tangent[~tangent.any(1), -1] = 1.0
    elif kind == 3:
        normal = rng.integers(-2, 3, (k, fewer)) @ rng.standard_normal((fewer, n))
        normal[~normal.any(1)] = rng.standard_normal(n)
        tangent = rng.integers(-2, 3, (k, fewer)) @ rng.standard_normal((fewer, n))
        tangent[~tangent.any(1)] = rng.standard_normal(n)
    velocity = rng.standard_normal(n) if rng.random() < 0.8 else rng.integers(-1, 2, n).astype(float)
    start, v = rng.integers(3), float(rng.choice([0.0, 0.5, 1.0]))
    if start == 0:
        normal = normal * np.where(normal @ velocity < 0.0, -1.0, 1.0)[:, None]
    if start == 1:
        velocity = np.zeros(n)
    _, kept = np.unique(np.hstack([normal, tangent]).round(12), axis=0, return_index=True)
    kept.sort()  # the same rows twice are refused
    friction = fl.Coulomb(mu_k=mu, mu_s=mu if rng.random() < 0.7 else mu + 0.3)
    contacts = fl.SlidingContacts(
        tangent[kept],
        normal[kept],
        fl.LinearContact(k2=float(rng.choice([1.0, 10.0, 1e3]))),
        friction,
        v=v,
        impact=impact,
        penetration=float(rng.choice([0.0, 0.0, 0.1])),
    )
    load = rng.standard_normal(n) * rng.integers(2)
    structure = fl.Structure((M + M.T) / 2, (K + K.T) / 2, contacts=contacts, load=load)
    return structure, np.append(np.zeros(n), velocity)
