"""Where stability changes, and what begins there.

``stability_changes``
    `fl.stability_changes`, `fl.critical_value`, `fl.critical_curve`: brackets of the changes of sign of the
    sorted growth rates along one parameter, and what these changes are.
``stability_map``
    `fl.stability_map`: a grid in a plane of two parameters, and the curves between its points.
``hopf``
    `fl.hopf`: the normal form at a flutter point, which says what vibration begins there.
"""
