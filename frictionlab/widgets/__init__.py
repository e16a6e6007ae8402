"""Interactive views in a notebook: explorers, runs that are watched, sound.

    explorer            `Explorer` and the three functions that make one
    result              what an explorer is set to; run, eigenvalues, spectrum, computed when asked for
    controls            the values of an explorer's state; they give a model and Settings
    front_end           the front end of `frictionlab.pages` as a widget, and results as data for it
    panels/             panels of one's own and of long work: functions of a Result that return a `Drawing`
    scenes              a menu of all models and scenes; `frictionlab app`
    update_scheduler    one update at a time, for the latest change
    watch, sound        `fl.watch` and `fl.listen`

A change of a control gives new Settings, and these a new Result.  Its data go to the browser, where the front
end draws them and says what they mean.
"""
