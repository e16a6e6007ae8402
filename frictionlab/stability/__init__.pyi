# The public names of frictionlab.stability, each once; `__init__.py` loads a name from its module when it is
# first used, as the modules of all take a second to load.

from .boundaries.hopf import HopfPoint as HopfPoint
from .boundaries.hopf import hopf as hopf
from .boundaries.stability_changes import CriticalCurve as CriticalCurve
from .boundaries.stability_changes import StabilityChange as StabilityChange
from .boundaries.stability_changes import critical_curve as critical_curve
from .boundaries.stability_changes import critical_value as critical_value
from .boundaries.stability_changes import stability_changes as stability_changes
from .boundaries.stability_map import Boundary as Boundary
from .boundaries.stability_map import StabilityMap as StabilityMap
from .boundaries.stability_map import stability_map as stability_map
from .eigenproblems.eigenvalues import Eigenvalues as Eigenvalues
from .eigenproblems.eigenvalues import eigenvalues as eigenvalues
from .eigenproblems.eigenvalues import jacobian as jacobian
from .eigenproblems.linear_system import FrequencyResponse as FrequencyResponse
from .eigenproblems.linear_system import LinearSystem as LinearSystem
from .eigenproblems.linear_system import linearize as linearize
from .eigenproblems.root_locus import RootLocus as RootLocus
from .eigenproblems.root_locus import root_locus as root_locus
from .equilibrium_points.equilibria import Equilibrium as Equilibrium
from .equilibrium_points.equilibria import equilibria as equilibria
from .equilibrium_points.equilibria import equilibrium as equilibrium

__all__: list[str]
