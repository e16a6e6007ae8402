"""How kernels become machine code: by their decorators, and ahead of time for each processor and system.

A kernel is a plain function on numbers and arrays with a decorator.  A build step compiles once those that
are called from outside.  The results are part of the repository, in the folder ``objects``, for every
processor and system and for browsers; to run them takes neither numba nor a compiler.
``python -m frictionlab.compilation --all`` makes them anew, ``--compare`` tells whether that would change
them.  While kernels are edited, ``python -m frictionlab.compilation`` compiles for this machine alone, into
``objects_of_machine``, which git ignores.

What kernels need when they are imported, each file only from those before it:

``targets``
    Processors and systems, and which of them fit this machine.
``kernel_sources``
    The files on which kernels depend, and digests of the code in them that matters.
``manifest``
    The file beside the objects that says what has been compiled, and from which sources.
``loaded_kernels``
    The object that fits this machine, and its functions as Python calls them.  It needs llvmlite, not numba.
``machine_code``
    What there is on this machine: `LOADED` kernels, else `NUMBA`, else neither.
``numba_internals``
    All that depends on undocumented parts of numba: what it has compiled, kept for later processes; its
    instructions in place of machine code.
``decorators``
    `kernel` and `inlined`: compiled ahead of time, else by numba, else plain Python.
``llvm_instructions``
    Arithmetic, loops and branches in LLVM, for the intrinsics of kernels and for the solver's ``codegen``.

The build step:

``entry_points``
    The list of what is compiled.  This one file imports kernels from all parts, so also from packages that
    stand above this one, and only the build step imports it.
``flat_functions``
    The kernels as numba's LLVM instructions, before any optimisation; around each entry point a function of
    one table of numbers and addresses.
``build``
    All of this in turn, and the machine code of each target.
``build_hook``
    What an installation does where the objects do not fit the sources.

How a function is called, in an object and in a browser (``objects/kernels.wasm``): ``int name(int64
*table)``, which returns 0. A table has little-endian words of 64 bits: first the results, then the
arguments in their order, fields of named tuples one after the other. An integer or a truth value is one
word; a float is one word, its bits; an array is the address of its first element, then its length along
each axis, with its elements row by row without gaps; None takes no word. The manifest lists the results and
the arguments of each function by name, type and number of axes, such as ``["run.times", "f8", 1]``.
Functions keep nothing between calls and allocate nothing.

The module for browsers exports these functions by their names; elementary functions of one float
(``frictionlab_exp`` and so on); ``memory`` and ``__indirect_function_table``, which both grow. Free memory
begins at ``__heap_base``. Addresses are below 2^32 and stand in a word's lower half. In ``code.native`` the
place of a mode's machine code in that table of functions stands for its address. The code is called as
``void jets(double *z, double *constants, double *terms, double *J, int64 order)``, with i32 for pointers.
"""
