"""From energies and contacts to a hybrid automaton.

`mechanics` has the classes in which a model states energies, loads, contacts and statics, without sympy;
`mechanical_model` is the base of models that do so.  `equations_of_motion` derives M q'' = r + sum of W F;
`coupled_masses` multiplies by M^-1 in numbers where masses are coupled, as those of finite elements;
`contact_regimes` lists the regimes of each contact (stick, slip, separation; flight, contact), what jumps at
its events, and the limit mode of ever shorter flights.  `modes` makes a mode of each combination of regimes,
and the automaton of all modes.
"""
