"""A model as one HTML file with the exact solver in it: `fl.export_page`.

``javascript``
    Expressions of sympy as JavaScript, to the last bit what Python computes of parameters; what a model
    checks when these are set, in the same words.
``page_data``
    What a page holds as data: structures of a model, with the tape's arrays, numbers, outputs and equilibria;
    sliders, switches and presets, checked.
``export``
    `export_page`: all of these in one file, with the kernels as WebAssembly.
``scripts/``
    The page itself: JavaScript and styles, one file for each concern.

A page holds every structure that its switches reach, each with all modes derived; in the browser
``solver.js`` runs them as the Taylor method does here, with the same kernels, so that states and events agree
to the last bit.
"""
