"""The figures of the paper as results: numbers, a summary in words, the picture on demand.

    linear_stability        Figs 2 to 6: modes that couple, critical friction against the preload
    bifurcations            Figs 7 to 15: single motions, steady states against mu_k and against the preload
    stiff_structure         Figs 16 to 18: with and without stick and separation; response frequencies

GN is the geometrical nonlinearity, in the paper's words.
"""
