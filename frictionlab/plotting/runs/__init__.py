"""Panels of one run (`Trajectory`).

    time_window       which part of the run is shown, its samples and modes; labels of panels over time
    time_histories    displacements, rates and contact forces against time
    phase_plane       a coordinate against its rate, coloured by mode
    spectrum          the amplitude spectrum of a state
    overview          `plot_run`: four of these in one figure

Each panel checks the run, takes dense samples of the window from it and draws them into its axes.
"""
