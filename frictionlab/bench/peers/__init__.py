"""The methods that are compared.

methods           all of them by name, each with the package it needs; our own without native code; and the
                  regularised model, whose friction and contact are smooth
external          base of the adapters: another tool integrates and finds the events, the rest is ours
adapters          scipy, CVODE, PathSim, which call back functions; heyoka, diffrax, which compile
"""
