"""A model as one HTML file with the exact solver in it: `fl.export_page`.

``javascript``
    Formulas as JavaScript that computes the same numbers as Python, to the last bit.
``cases``
    The rules that a model checks when parameters are set, with the same messages, and its picture.
``python_text``
    Python that makes a model and its run, as explorers and pages copy it.
``page_data``
    The data of a page: structures of a model, with the tape's arrays, numbers, outputs and equilibria;
    sliders, switches and presets, checked.
``export``
    `export_page`: all of these in one file, with the kernels as WebAssembly.
``gallery``
    A folder of pages of all models of the library, with an index.
``scripts/``
    The page itself: JavaScript and styles, one file for each concern.

A page holds the structure for every combination of its switches, each with all modes derived.  In the browser
``solver.js`` runs them as the Taylor method does in Python, with the same kernels, so that states and events
agree to the last bit.
"""
