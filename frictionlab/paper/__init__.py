"""The paper's figures and claims, computed again.

N. Liu, H. Ouyang, "Friction-induced vibration considering multiple types of nonlinearities", Nonlinear
Dynamics (2020).

>>> import frictionlab as fl
>>> print(fl.paper.figure(6))
Fig. 6: eigenvalues with and without the geometrical nonlinearity, F = 1000 N, l1 = 0.1 m, l2 = 0.3 m
with GN: 0 -> 1 at mu_k 0.6897 (12.88 Hz), 1 -> 2 at 1.1943 (17.66 Hz), 2 -> 1 at 2.0890 (13.44 Hz)
without GN: 0 -> 1 at mu_k 1.8717 (16.48 Hz)

    results          `figure` and `claims`, and which module computes each; PaperFigure, Claim, the table of
                     verdicts; the check of one claim in three ways
    scenes           solver settings, models and grids of parameters that the paper's computations use; their
                     steady states, computed once; results in words
    figures/         the figures as results: data, summary, picture
    checks/          the claims, each computed in up to three ways, with a verdict
    step_sizes       what a fixed step does to a motion
    report           all figures and claims as pages: `frictionlab reproduce`

results and report pass a Setting to figures and checks, which take steady states from the sweeps of scenes
and give the numbers.
"""

from __future__ import annotations

from .results import Claim, Claims, PaperFigure, Verdict, claims, figure

__all__ = ["Claim", "Claims", "PaperFigure", "Verdict", "claims", "figure"]
