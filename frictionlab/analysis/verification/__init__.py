"""Whether a run can be trusted.

`verify` runs a model again by other methods and from a neighbouring state; `run_comparison` compares two runs
in their events and, between these, in their states, and samples the defects of steps of one run, for the
sentence that steady states and explorers show.
"""
