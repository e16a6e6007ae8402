"""The models of the package, one file each, and `catalogue`, the table of them (`fl.list_models`).

`parameter_presets` makes the parameters that several models have.
"""
