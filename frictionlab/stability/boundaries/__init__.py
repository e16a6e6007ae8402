"""Where stability changes, and what begins there.

``sign_changes``
    Brackets of the changes of sign of the sorted growth rates along one parameter.
``stability_changes``
    `fl.stability_changes`, `fl.critical_value`, `fl.critical_curve`: solve for these changes and name them.
``stability_map``
    `fl.stability_map`: a grid in a plane of two parameters, and the curves between its points.
``hopf``
    `fl.hopf`: the normal form at a flutter point, which says what vibration begins there.
"""
