"""Analyses of models: runs, and what can be learnt from them.

``simulate``, ``ensemble``, ``load``
    One run of a model; many runs at once; a run from a file.  ``initial_states`` has what they begin from.
``lyapunov``, ``motion_scales``, ``energy_audit``, ``impulses``, ``parameter_flow``
    Of a motion: its exponents; its ranges, period and spectrum; its energy balance; the impulses of its
    impacts; its derivatives by parameters.
``verify``
    Whether a run can be trusted.  ``run_conditions`` judges it by the conditions of its modes,
    ``stated_conditions`` and ``stated_mechanics`` by what the model states, ``run_comparison`` by other runs,
    one of them by ``independent_method``.
``options``
    Settings that several analyses share.
``steady_state``
    What a motion settles to.
``orbits``
    Periodic orbits, their multipliers, and their branches along a parameter.
``sweeps``
    Many runs over parameters, in workers, resumable.
``basins``
    Which initial states lead to which attractor.
``quantities``
    Numbers with exact derivatives: sensitivity, uncertainty, optima.
``fitting``
    Parameters from measurements.

Analyses take `Trajectory` objects from the solver and return frozen dataclasses with arrays.
"""
