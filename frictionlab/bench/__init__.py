"""Benchmarks: run time against error, other tools included; what `frictionlab bench` prints and writes.

    scenes              runs with a known end
    harness             compiled code made ready, runs timed in turns, a row for each method on a scene
    peers/              the methods that are compared: ours, and other tools on the same automaton
    nonlinearity_cost   the eight scenes without nonlinearities; first calls, native code of each mode
    parallel_runs       runs side by side in lanes; Fig. 9's sweep by one worker and by two
    stability_cost      many eigenvalue problems at once; Floquet multipliers
    basins              basin stability by events, against a model made smooth
    missed_event        one landing that a fixed step does not see
    explorer_latency    a step of an explorer's slider
    page_frames         size of exported pages, and how pictures follow a slider
    performance_page, exact_and_fast_page, page_figures     docs/performance.md and docs/exact-and-fast.md

A scene and a method give rows, rows give tables and pictures, these the pages.
"""
