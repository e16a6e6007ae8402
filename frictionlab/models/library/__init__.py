"""The models of the package, similar ones in one file, and `catalogue`, their table (`fl.list_models`).

`parameters` makes the parameters that several models have, and lists the keywords of each model.
"""
