"""The energy balance of a run that starts at a state and in a mode."""

import frictionlab as fl


def residual(model, t_end, x0, mode=None):
    """What the energy balance misses over a run from a state on (J), and the energy that is turned over."""
    options = {"t_eval": [0.0, t_end], "progress": False, "source": model}
    run = fl.solve(model.automaton(), t_end, x0=x0, mode=mode, **options)
    assert run.status is fl.Status.FINISHED
    audit = fl.energy_audit(run, progress=False)
    return audit.residual[-1], audit.turned_over


def assert_balanced(run, limit=1e-9):
    """The energy balance of a run of a slider closes, as a share of the energy turned over."""
    error = fl.energy_audit(run, progress=False).error
    assert error < limit
