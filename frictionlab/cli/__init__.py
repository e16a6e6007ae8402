"""The command `frictionlab`: `main` is its entry point.

    command        `main`: reads the arguments, calls the command, turns interruptions into exit statuses
    parsing        what the commands share: parser, spellings, models by name with parameter values, options
                   of sweeps, checks of files, JSON
    run            `frictionlab run` and what it prints
    models         `frictionlab models`
    stability      `frictionlab eig` and `frictionlab critical`
    film_and_sound `frictionlab animate` and `frictionlab sound`
    page           `frictionlab page`
    app            `frictionlab app`; app_server is what it serves
    course, warmup `frictionlab course` and `frictionlab warmup`
    paper          `frictionlab figure` and `frictionlab reproduce`
    shipped_structures
                   for building wheels only: the models' structures derived beforehand

Each command has a function `add_...`, which adds its options, and a function `..._command`, which checks them
all, does the work and returns the exit status.  What a command needs beyond its options is imported when it
runs.
"""
