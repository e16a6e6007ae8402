"""Machine code of modes, written with llvmlite, whose results equal those of the kernels to the last bit.

``jet_codegen``
    The jets of a mode (:mod:`frictionlab.hybrid.kernels.jets`), for one run, and for several side by side
    (lanes); the kernels that native code calls by name, for values and ranges of functions.
``side_by_side``
    The affine sums and states of a tape that are one vector there.
``remainder_codegen``
    The ranges and bounds of :mod:`frictionlab.hybrid.kernels.remainder`, for lanes.
``step_codegen``
    A whole step without an event, for lanes.
``native_cache``
    When a mode's code is compiled (in the background, once it has been used for long), and where it is kept.

From a `Program` the cache takes the tape of a mode (`ModeTape`), a writer turns it into an LLVM module, and
the address of the compiled function goes into the program's `Code`, where the kernels find it.
"""
