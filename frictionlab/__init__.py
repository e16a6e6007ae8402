"""Friction-induced vibration: models, an exact event-driven solver, stability, figures.

>>> import frictionlab as fl
>>> model = fl.SliderOnBelt(mu_k=1.4)
>>> run = fl.simulate(model, 1.0)

Names are loaded when they are first used, so that the import itself costs nothing.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

from frictionlab._version import __version__

if TYPE_CHECKING:
    from frictionlab import paper, testing
    from frictionlab.analysis.ablation import ablation
    from frictionlab.analysis.basins import Basins, BasinStability, basin_stability, basins, load_basins
    from frictionlab.analysis.bifurcation import bifurcation
    from frictionlab.analysis.branch import Bifurcation, load_bifurcation
    from frictionlab.analysis.continuation import OrbitBranch, continue_orbit
    from frictionlab.analysis.energy import EnergyAudit, energy_audit
    from frictionlab.analysis.ensemble import Ends, ensemble
    from frictionlab.analysis.lyapunov import LyapunovSpectrum, lyapunov
    from frictionlab.analysis.periodic_orbit import PeriodicOrbit, periodic_orbit
    from frictionlab.analysis.simulate import load, simulate
    from frictionlab.analysis.steady_state import steady_state
    from frictionlab.analysis.sweep import sweep
    from frictionlab.analysis.verify import Verification, verify
    from frictionlab.analysis.window import SteadyState
    from frictionlab.automaton import Event, HybridAutomaton, Mode, Reset
    from frictionlab.components import (
        ContactLaw,
        Coulomb,
        CubicContact,
        ExponentialDecay,
        FixedLoad,
        FrictionalImpact,
        FrictionLaw,
        HertzContact,
        ImpactLaw,
        LinearContact,
        MovingLoad,
        PlasticImpact,
        PolynomialContact,
        PressureDependent,
        RestitutionImpact,
        SlidingOnly,
        SlidingSeparation,
        StickSlip,
        StickSlipSeparation,
        Stribeck,
        WeakeningStrengthening,
        functions,
        parameter,
    )
    from frictionlab.hybrid.rk4 import RK4
    from frictionlab.hybrid.scipy_methods import Scipy
    from frictionlab.hybrid.solve import solve
    from frictionlab.hybrid.status import Status
    from frictionlab.hybrid.tangent_flow import TangentFlow, tangent_flow
    from frictionlab.hybrid.taylor import Taylor
    from frictionlab.hybrid.trajectory import Trajectory
    from frictionlab.models import (
        BouncingBall,
        DenHartog,
        FreeCoulomb,
        ImpactOscillator,
        MassOnBelt,
        MechanicalModel,
        ModeCoupling,
        Model,
        SliderOnBelt,
        SliderOnRigidBelt,
        TwoBlocks,
        list_models,
    )
    from frictionlab.plotting import animate, plot_run
    from frictionlab.stability import (
        critical_curve,
        critical_value,
        eigenvalues,
        equilibria,
        equilibrium,
        hopf,
        root_locus,
        stability_changes,
        stability_map,
    )
    from frictionlab.widgets.bifurcation import explore_bifurcation
    from frictionlab.widgets.canvas import watch
    from frictionlab.widgets.explorer import explore
    from frictionlab.widgets.sound import Sound, listen
    from frictionlab.widgets.stability import explore_stability

# Public name -> module that holds it.
_HOMES = {
    "analysis.ablation": "ablation",
    "analysis.basins": "basins basin_stability Basins BasinStability load_basins",
    "analysis.bifurcation": "bifurcation",
    "analysis.branch": "Bifurcation load_bifurcation",
    "analysis.continuation": "continue_orbit OrbitBranch",
    "analysis.energy": "energy_audit EnergyAudit",
    "analysis.ensemble": "ensemble Ends",
    "analysis.lyapunov": "lyapunov LyapunovSpectrum",
    "analysis.periodic_orbit": "periodic_orbit PeriodicOrbit",
    "analysis.simulate": "simulate load",
    "analysis.steady_state": "steady_state",
    "analysis.sweep": "sweep",
    "analysis.verify": "verify Verification",
    "analysis.window": "SteadyState",
    "automaton": "HybridAutomaton Mode Event Reset",
    "components": "ContactLaw CubicContact LinearContact HertzContact PolynomialContact FrictionLaw Coulomb "
    "ExponentialDecay Stribeck WeakeningStrengthening PressureDependent MovingLoad FixedLoad ImpactLaw "
    "PlasticImpact RestitutionImpact FrictionalImpact StickSlipSeparation StickSlip SlidingSeparation "
    "SlidingOnly parameter functions",
    "hybrid.rk4": "RK4",
    "hybrid.scipy_methods": "Scipy",
    "hybrid.solve": "solve",
    "hybrid.status": "Status",
    "hybrid.tangent_flow": "tangent_flow TangentFlow",
    "hybrid.taylor": "Taylor",
    "hybrid.trajectory": "Trajectory",
    "models": "SliderOnBelt SliderOnRigidBelt MassOnBelt FreeCoulomb DenHartog ModeCoupling BouncingBall "
    "ImpactOscillator TwoBlocks Model MechanicalModel list_models",
    "plotting": "animate plot_run",
    "stability": "equilibria equilibrium eigenvalues root_locus stability_changes critical_value "
    "critical_curve stability_map hopf",
    "widgets.canvas": "watch",
    "widgets.sound": "Sound listen",
    "widgets.bifurcation": "explore_bifurcation",
    "widgets.explorer": "explore",
    "widgets.stability": "explore_stability",
}
_HOME = {name: module for module, names in _HOMES.items() for name in names.split()}
_PACKAGES = ("paper", "testing")

__all__ = [  # static tools read the imports above
    "__version__",
    *_HOME,
    *_PACKAGES,
]


def __getattr__(name: str) -> Any:
    if name in _HOME:
        value = getattr(import_module(f"frictionlab.{_HOME[name]}"), name)
        globals()[name] = value
        return value
    if name in _PACKAGES:
        return import_module(f"frictionlab.{name}")
    from difflib import get_close_matches

    close = get_close_matches(name.lower(), [n.lower() for n in __all__], n=1)
    hint = [f": did you mean {n!r}?" for n in __all__ if [n.lower()] == close][:1]
    raise AttributeError(f"module 'frictionlab' has no attribute {name!r}{''.join(hint)}")


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
