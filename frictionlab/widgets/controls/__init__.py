"""Controls of an explorer, made from what is known about parameters and components.

sliders           one slider for a parameter: symbol, unit, range, scale; the rounding of browsers removed
model_controls    all sliders, switches of the nonlinearities, the impact law: they give a model
run_controls      initial state, duration, method, and what is shown: they give Settings for that model
"""
