"""Panels of one run (`Trajectory`).

    time_histories    which part of the run is shown, its samples and modes; displacements, rates and contact
                      forces against time
    overview          a coordinate against its rate, coloured by mode; the amplitude spectrum of a state;
                      `plot_run`: four of these in one figure; energies and works, and what a verification
                      found

Each panel checks the run, takes dense samples of the window from it and draws them into its axes.
"""
