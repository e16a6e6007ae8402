"""How a run depends on its initial state.

``tangent_jets``
    Taylor series of the variational equation, and the kernel that carries tangent vectors over the steps of a
    run; the saltation matrix of an event.
``tangent_flow``
    `fl.tangent_flow`, the fundamental matrix of a run, and the growth of orthonormal tangent vectors
    (Lyapunov exponents).

All take a finished `Trajectory` of the Taylor method: over its steps tangent vectors follow the series, at
its events they are multiplied by saltation matrices.
"""
