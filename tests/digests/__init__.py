"""Digests of runs: what is promised to be the same to the last bit on every machine.

``python -m tests.digests`` runs everything in `runs` and names what differs from the digests in
``digests.json``; the exit code is how many do.  Whoever has another processor, another compiler or no numba
(``FRICTIONLAB_DISABLE_NUMBA=1``, some minutes) runs it to check that promise.  ``--write`` writes the file
anew, after a change that is meant to change results.  ``python -m tests.digests.web`` compares with the
module for browsers, in node.  ``nox -s aarch64`` runs it on an emulated ARM processor.
"""
