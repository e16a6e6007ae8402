"""Controls of an explorer, made from what is known about parameters and components.

number_control    label, slider, field and message of one number; in the browser number_control.js
sliders           the control of a parameter: symbol, unit, range, scale, the positions of its slider
file_button       a button that makes a file for the browser, or a text to copy
model_controls    all sliders, switches of the nonlinearities, the impact law: they give a model
run_controls      initial state, duration, method, and what is shown: they give Settings for that model
"""
