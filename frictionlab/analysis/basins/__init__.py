"""Basins of attraction.

`basins` makes the initial states and checks the arguments.  `tasks` runs a few of them to the end,
which gives the known attractors (`attractors`), then runs all of them in groups, side by
side, each until it is near a known attractor. `result` puts the labels of all groups together in a `Basins`
or a `BasinStability`.
"""
