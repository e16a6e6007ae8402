"""All pictures that the package draws of its results, as functions that give figures."""

import frictionlab as fl
from frictionlab import plotting

from .results import BUILDERS, result

NOT_DRAWN = {
    *("stability change", "boundary", "special orbit", "attractor", "events", "section points"),
    "reduced structure",
}
ANIMATIONS = []  # kept, as one that is deleted before it is shown gives a warning


def first_frame(name, window):
    """The figure of an animation."""
    ANIMATIONS.append(fl.animate(result(name), window=window))
    return ANIMATIONS[-1]._fig


OTHERS = {
    "overview": lambda: fl.plot_run(result("run")),
    "overview of two contacts": lambda: fl.plot_run(result("run of two contacts")),
    "phase plane": lambda: plotting.plot_phase_plane(result("run"))[0].figure,
    "rates": lambda: plotting.plot_rates(result("run"))[0].figure,
    "contact forces": lambda: plotting.plot_contact_forces(result("run"))[0].figure,
    "spectrum of a run": lambda: plotting.plot_spectrum(result("run of two contacts"))[0].figure,
    "frequencies": lambda: plotting.plot_frequencies(result("locus"))[0].figure,
    "growth rates": lambda: plotting.plot_growth_rates(result("locus"))[0].figure,
    "intensity": lambda: plotting.plot_intensity(result("bifurcation"))[0].figure,
    "works": lambda: plotting.plot_works(result("energies"))[0].figure,
    "equilibrium of a block": lambda: fl.equilibrium(fl.SliderOnRigidBelt()).plot().figure,
    "animation": lambda: first_frame("run", 0.1),
    "animation of a block": lambda: first_frame("run of two contacts", 2.0),
}


def figures():
    """Name -> function that draws a figure."""
    own = {name: lambda name=name: result(name).plot().figure for name in BUILDERS if name not in NOT_DRAWN}
    return own | OTHERS
