"""The command `frictionlab`: `main` is its entry point.

    command        `main`: reads the arguments, calls the command, turns interruptions into exit statuses
    completion     `frictionlab completion`
    parsing        what the commands share: parser, spellings, models by name with parameter values, options
                   of sweeps, checks of files, JSON
    models         `frictionlab models`, `frictionlab eig` and `frictionlab critical`
    run            `frictionlab run` and what it prints
    media          `frictionlab animate`, `frictionlab sound`, `frictionlab page` and `frictionlab app`
    app_server     what `frictionlab app` serves
    preparation    `frictionlab course` and `frictionlab warmup`; and, for building wheels only, the models'
                   structures derived beforehand
    reports        `frictionlab figure` and `frictionlab reproduce`

Each command has a function `add_...`, which adds its options, and a function `..._command`, which checks them
all, does the work and returns the exit status.  What a command needs beyond its options is imported when it
runs.
"""
