"""The models of the package, those that are akin in one file, and `catalogue`, the table of them
(`fl.list_models`).

`parameters` makes the parameters that several models have, and lists the keywords of each.
"""
