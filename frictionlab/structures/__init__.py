"""Structures of many freedoms from matrices, as finite-element programs export them.

`Structure` holds M, C, K and what else the equations of small motion have, each a sum of sparse matrices
whose coefficients depend on named parameters.  No full matrix of all freedoms is formed, but of small ones.

``matrix_files``
    Matrices from files.
``parametric_matrix``
    `ParametricMatrix`: a sum of coefficients times sparse matrices.
``matrix_function``
    A function of parameters that gives a matrix, as the sum that it computes.
``structure``
    `Structure`: the matrices, checked, the values of the parameters, the window of frequencies.
``sliding_contacts``, ``sliding_equilibrium``
    `SlidingContacts`: rows of the freedoms with laws; the static displacements with them.
``steady_friction``
    Friction laws with states of their own in steady sliding.
``beam_on_belt``, ``disc_brake``
    `BeamOnBelt` and `DiscBrake`: structures from their dimensions.
``structure_data``
    A structure as data that a file can hold.
``motion``
    The hybrid automaton of a structure, by which it moves.
``energy_balance``
    `StructureBalance`: energies and powers along its motion.
``quadratic_pencil``
    `QuadraticPencil`: s^2 M + s C + K at one set of values, and its eigenvalues in a window.
``bases``, ``reduction``
    `reduce`: few freedoms with the modes of a large structure, on complex modes, real modes or those of Craig
    and Bampton; modes at samples of the parameters, and errors.
``eigenvalue_bounds``
    How far known eigenvalues are at most from exact ones.
``mode_paths``
    Root loci and maps of structures.
``changes_of_stability``
    Where the stability of a structure changes along a parameter.
``window_eigenvalues``
    `WindowEigenvalues`: eigenvalues of a structure with errors, left vectors and sensitivities.
"""
