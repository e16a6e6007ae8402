"""The zoo: systems of the literature, each a class of a few lines, a topic in a file.

They are loaded when one of them, or their table, is first asked for: ``fl.list_models("impacts")``.

``zoo_model``
    The base of all, and why some do not take some analyses.
``belt_oscillators``, ``mode_couplings``, ``rotating_systems``, ``bristles_and_states``, ``impacts``,
``structures_in_modes``
    The models.
``topics``
    Which models a topic has, in the order of the table.
"""
