"""Kernels compiled ahead of time: objects for each processor and system, and a module for browsers.

A build step compiles the entry points of the kernels once; the package carries what it made in the folder
``objects``, and neither numba nor a compiler is needed to run it.  ``python -m
frictionlab.hybrid.ahead_of_time`` compiles for this machine, with ``--all`` for every target, with
``--target`` for one, with ``--web`` for browsers.

``manifest``
    What has been compiled, the file beside the objects; the sources that it depends on; processors and
    systems, and which of them this machine is.
``loaded_kernels``
    The object that fits this machine, its functions as Python calls them.  It needs llvmlite only.
``entry_points``
    The list of what is compiled.
``flat_functions``
    numba's instructions of the kernels before any optimisation; functions of one table of numbers and
    addresses around them.
``build``, ``build_hook``
    All of this in turn, and machine code of each target; as a command, and when a wheel is made.

How a function is called, in an object and in a browser (``objects/kernels.wasm``): ``int name(int64
*table)``, which returns 0. A table has words of 64 bits, little end first: first the results, then the
arguments in their order, fields of named tuples one after the other. An integer or a truth value is one
word; a float is one word, its bits; an array is the address of its first element, then its length along
each axis, its elements row by row without gaps; None is no word. The manifest has for each function the
names, types and numbers of axes of both, ``["run.times", "f8", 1]``. Functions keep nothing between calls
and allocate nothing.

The module for browsers exports them by their names, ``frictionlab_exp`` and so on of one float, ``memory``
(which grows; what is free begins at ``__heap_base``) and ``__indirect_function_table`` (which grows too).
Addresses are below 2^32 and stand in a word's lower half. Machine code of a mode is called by its place in
that table of functions, which stands for an address in ``code.native``: ``void jets(double *z, double
*constants, double *terms, double *J, int64 order)``, with i32 for pointers.
"""
