"""The paper's slider on a belt that does not tilt, as matrices."""

import numpy as np

import frictionlab as fl


def slider_on_belt(model: fl.SliderOnBelt) -> fl.Structure:
    """Matrices of Eqs. (1) to (3) by hand: x1, y1, x2, y2 of a model with a fixed load."""
    half = model.k3 / 2
    K = np.diag([model.k1 + half, half, model.k4, model.k5 + model.k6])
    K[0, 1] = K[1, 0] = -half
    contacts = fl.SlidingContacts(
        fl.relative_rows([(0, 2)], 4),
        fl.relative_rows([(3, 1)], 4),
        model.contact,
        model.friction,
        model.v,
        impact=model.impact,
    )
    return fl.Structure(
        np.diag([model.M, model.M, model.m, model.m]),
        K,
        np.diag([model.c1, model.c2, model.c4, model.c5 + model.c6]),
        load=[("F", [0.0, -1.0, 0.0, 0.0])],
        contacts=contacts,
        parameters={"F": model.F},
    )
