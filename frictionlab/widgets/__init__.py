"""Interactive views in a notebook: explorers, a live canvas, sound.

    explorer            `Explorer` and the three functions that make one
    result              what an explorer is set to; run, eigenvalues, spectrum, computed when asked for
    controls            sliders, switches and lists, made from a model's metadata; they give Settings
    number_control      label, slider, field and message of one number; in the browser number_control.js
    panels/             functions of a Result that return a `Drawing`; Drawings painted as PNGs
    scenes              a menu of all models and scenes above the explorer, and links that set it
    state               what the controls are set to, undo and redo; figures, data and states as files
    layout              the arrangement of all widgets, full screen and themes; the texts beside the picture
    update_scheduler    one update at a time, for the latest change; the busy indicator
    canvas, sound       `fl.watch` and `fl.listen`

A change of a control gives new Settings, and these a new Result.  The panels make Drawings of it; the picture
paints them and sends the images to the browser.
"""
