"""The energy balance of a run.

`balance_terms` gives energies and powers at states; `energy_audit` integrates the powers along the run's
Taylor polynomials and compares the works with the change of energy.
"""
