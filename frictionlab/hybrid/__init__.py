"""The solver: it runs any hybrid automaton and knows nothing of friction.

:mod:`frictionlab.tape` makes a `Program` of an automaton, the arrays of all its tapes, guards, resets and
sections, and `Numbers`, its coefficients at values of the parameters.  From there data pass in this order:

``kernels``
    What is computed with these arrays: Taylor series (jets), the length of a step, the location of events,
    the choice of the next mode, resets, the loop of steps.
``codegen``
    Machine code for the jets and steps of a mode that is used for long, with the same results to the last
    bit.
``problem``
    `Problem`, what a method is given; `RunData`, the arrays that it gives back; `Status`, how a run ended.
``methods``
    `Taylor`, `RK4`, `Scipy`: classes that fill records of steps and events.
``chatter_limit``
    How short flights must be for the limit of chatter to take their place.
``trajectory``, ``run_events``, ``outputs``, ``run_file``
    `Trajectory`, the result of a run with samples and dense output; its `Events`; its named outputs; its
    file, and the check of arrays read from it.
``accuracy``, ``guard_bounds``, ``real_powers``
    Checks of a run: the defect of its steps and the violation of its modes' conditions; where guards are
    negative, by intervals; whether the base of a power became negative.
``ensemble``
    Many runs of one structure side by side.
``variational``
    How a run depends on its initial state: tangent flow, saltation matrices, growth of perturbations.
``solve``
    `fl.solve`, which checks the arguments and passes an automaton through all of this; methods by name.
``free_memory``
    The memory that a run can still take.
"""
