"""Fits of parameters to measurements.

`data` holds measurements: time records, spectra, event times, eigenfrequencies.  `predictions` cuts the time
into pieces, runs a model piece by piece and gives what it predicts, with exact derivatives through events.
`fit` (`fl.fit`) is multiple shooting with `scipy.optimize.least_squares`, then one run through all data; a
`Fit` has the confidence intervals and tells what is not identifiable.
"""
