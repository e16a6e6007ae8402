"""Benchmarks: run time against error, other tools included; what `frictionlab bench` prints and writes.

    harness             scenes, which are runs with a known final state; code compiled beforehand, runs timed
                        in turns, a row for each method on a scene
    peers/              the methods that are compared: ours, and other tools on the same automaton
    single_costs        the eight scenes without nonlinearities; first calls, native code of each mode;
                        where the time of a run goes
    stability_costs     many eigenvalue problems at once; exact derivatives beside the quantity alone; Floquet
                        multipliers
    many_runs           runs side by side in lanes; Fig. 9's sweep by one worker and by two; basin stability
                        by events, against a model made smooth
    growth              time and memory against contacts, states, events, length, values, workers
    response_times      a step of an explorer's slider; size of exported pages, and how pictures
                        follow a slider
    performance_page, page_figures      docs/performance.md and docs/exact-and-fast.md, their pictures, and
                        a landing that a fixed step misses

A scene and a method give rows, rows give tables and pictures, and these make the pages.
"""
