"""Basins of attraction.

`basins` makes the initial states and checks the arguments.  `tasks` runs a few of them to the end,
which gives the known attractors (`attractors`), then runs all of them in groups, side by
side, each until it is near a known attractor. The labels of all groups come together in a `Basins`
or a `BasinStability`.
"""
