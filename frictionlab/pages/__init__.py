"""A model as one HTML file with the exact solver in it: `fl.export_page`.

``javascript``
    Expressions of sympy as JavaScript, to the last bit what Python computes of parameters.
``structure``
    One structure of a model as data: the tape's arrays, its numbers, outputs and equilibria.
``parameter_rules``
    What a model checks when parameters are set, for the page to check in the same words.
``controls``
    The sliders, switches and presets of a page, checked.
``solver_file``
    The kernels as WebAssembly, and how they take their arguments.
``export``
    `export_page`: all of these in one file.
``scripts/``
    The page itself: JavaScript and styles, one file for each concern.

A page holds every structure that its switches reach, each with all modes derived; in the browser
``solver.js`` runs them as the Taylor method does here, with the same kernels, so that states and events agree
to the last bit.
"""
