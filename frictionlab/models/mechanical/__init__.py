"""From energies and contacts to a hybrid automaton.

`mechanics` is what a model gives, without sympy: energies, loads, contacts, statics; `mechanical_model` is
the base of models that do.  `equations_of_motion` makes matrices of the energies, M q'' = r + sum of W F;
`coupled_masses` multiplies by M^-1 in numbers where masses are coupled, as those of finite elements;
`contact_regimes` lists the regimes of each contact (stick, slip, separation; flight, contact), what jumps at
its events, and the limit mode of ever shorter flights.  `modes` makes one mode of every
combination of regimes, and the automaton of all modes.
"""
