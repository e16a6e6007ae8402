"""The models of the package, one file each, and `catalogue`, the table of them (`fl.list_models`).

`parameters` makes the parameters that several models have, and lists the keywords of each.
"""
