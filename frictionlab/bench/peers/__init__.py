"""The methods that are compared.

methods           all of them by name, each with the package it needs; our own without native code
external          base of the adapters: another tool integrates and finds the events, the rest is ours
callback_adapters, compiled_adapters    scipy, CVODE, PathSim; heyoka, diffrax
regularised       not a method but another model: friction and contact made smooth
"""
