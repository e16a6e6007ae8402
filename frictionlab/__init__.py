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
    from frictionlab.analysis.basins.basins import (
        Basins,
        BasinStability,
        basin_stability,
        basins,
        load_basins,
    )
    from frictionlab.analysis.continuation.continue_orbit import OrbitBranch, continue_orbit
    from frictionlab.analysis.energy.energy_audit import EnergyAudit, energy_audit
    from frictionlab.analysis.ensemble import BatchResult, ensemble
    from frictionlab.analysis.lyapunov import LyapunovSpectrum, lyapunov
    from frictionlab.analysis.orbits.periodic_orbit import PeriodicOrbit, periodic_orbit
    from frictionlab.analysis.simulate import load, simulate
    from frictionlab.analysis.steady_state.result import SteadyState
    from frictionlab.analysis.steady_state.steady_state import steady_state
    from frictionlab.analysis.sweeps.ablation import ablation
    from frictionlab.analysis.sweeps.bifurcation import bifurcation
    from frictionlab.analysis.sweeps.bifurcation_result import Bifurcation, load_bifurcation
    from frictionlab.analysis.sweeps.sweep import sweep
    from frictionlab.analysis.verification.verify import Verification, verify
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
    from frictionlab.hybrid.methods.one_step import RK4, OneStepMethod
    from frictionlab.hybrid.methods.runge_kutta import Tableau
    from frictionlab.hybrid.methods.scipy_methods import Scipy
    from frictionlab.hybrid.methods.taylor import Taylor
    from frictionlab.hybrid.problem import Status
    from frictionlab.hybrid.solve import solve
    from frictionlab.hybrid.trajectory import Trajectory
    from frictionlab.hybrid.variational.tangent_flow import TangentFlow, tangent_flow
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
    from frictionlab.widgets.canvas import watch
    from frictionlab.widgets.explorer import explore, explore_bifurcation, explore_stability
    from frictionlab.widgets.sound import Sound, listen

# Public name -> module that holds it.
_HOMES = {
    "analysis.basins.basins": "basins basin_stability Basins BasinStability load_basins",
    "analysis.continuation.continue_orbit": "continue_orbit OrbitBranch",
    "analysis.energy.energy_audit": "energy_audit EnergyAudit",
    "analysis.ensemble": "ensemble BatchResult",
    "analysis.lyapunov": "lyapunov LyapunovSpectrum",
    "analysis.orbits.periodic_orbit": "periodic_orbit PeriodicOrbit",
    "analysis.simulate": "simulate load",
    "analysis.steady_state.result": "SteadyState",
    "analysis.steady_state.steady_state": "steady_state",
    "analysis.sweeps.ablation": "ablation",
    "analysis.sweeps.bifurcation": "bifurcation",
    "analysis.sweeps.bifurcation_result": "Bifurcation load_bifurcation",
    "analysis.sweeps.sweep": "sweep",
    "analysis.verification.verify": "verify Verification",
    "automaton": "HybridAutomaton Mode Event Reset",
    "components": "ContactLaw CubicContact LinearContact HertzContact PolynomialContact FrictionLaw "
    "Coulomb ExponentialDecay Stribeck WeakeningStrengthening PressureDependent MovingLoad FixedLoad "
    "ImpactLaw PlasticImpact RestitutionImpact FrictionalImpact StickSlipSeparation StickSlip "
    "SlidingSeparation SlidingOnly parameter functions",
    "hybrid.methods.one_step": "RK4 OneStepMethod",
    "hybrid.methods.runge_kutta": "Tableau",
    "hybrid.methods.scipy_methods": "Scipy",
    "hybrid.methods.taylor": "Taylor",
    "hybrid.problem": "Status",
    "hybrid.solve": "solve",
    "hybrid.trajectory": "Trajectory",
    "hybrid.variational.tangent_flow": "tangent_flow TangentFlow",
    "models": "SliderOnBelt SliderOnRigidBelt MassOnBelt FreeCoulomb DenHartog ModeCoupling BouncingBall "
    "ImpactOscillator TwoBlocks Model MechanicalModel list_models",
    "plotting": "animate plot_run",
    "stability": "equilibria equilibrium eigenvalues root_locus stability_changes critical_value "
    "critical_curve stability_map hopf",
    "widgets.canvas": "watch",
    "widgets.explorer": "explore_bifurcation explore explore_stability",
    "widgets.sound": "Sound listen",
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
