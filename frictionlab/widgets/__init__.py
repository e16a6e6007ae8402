"""Interactive views in a notebook: explorers, a live canvas, sound.

    explorer            `Explorer` and the three functions that make one
    result              what an explorer is set to; run, eigenvalues, spectrum, computed when asked for
    controls            sliders, switches and lists, made from a model's metadata; they give Settings
    number_control      label, slider, field and message of one number; in the browser number_control.js
    panels/             functions of a Result that return a `Drawing`, and from Drawings to PNGs
    scenes              a menu of all models and scenes above the explorer, and links that set it
    state               what the controls are set to, undo and redo; figures, data and states as files
    layout              the arrangement of all widgets, full screen and themes; the texts beside the picture
    update_scheduler    updates of which only the latest is computed; the busy indicator
    canvas, sound       `fl.watch` and `fl.listen`

A change of a control makes Settings, these a Result, the panels draw from it, the picture is painted and
sent.
"""
