"""Benchmarks: run time against error, other tools included; what `frictionlab bench` prints."""
