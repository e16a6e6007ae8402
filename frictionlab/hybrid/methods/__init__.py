"""Methods of integration: each a frozen dataclass with its settings, and the kernels that are its own.

``base``
    `Method`: the caps of a run, the choice of its first mode, and the loop that hands out records and joins
    them.
``taylor``
    `Taylor`, the exact event-driven method, and the matrix by which it steps through linear scenes without
    events.
``one_step``
    `OneStepMethod`, a base for methods of fixed steps, and `RK4`, the algorithm of the paper's Fig. 19.
``runge_kutta``
    `Tableau`, and the compiled steps of the method that it defines; what is done at the end of a step: find
    the condition that fails, record the step, choose the next mode.
``scipy_methods``
    `Scipy`: scipy's integrators on the same automaton.

`Method.integrate` takes a `Problem` and gives `RunData`; in between it calls the method's `advance`, which
fills a `Record` until that is full or the run ends.
"""
