"""What the package does when files are damaged, disks are full and processes are killed.

``python -m tests.faults`` does all of it, ``python -m tests.faults files --flips 20`` a part; the tests of
``tests/integration/test_faults.py`` do a short form.

``damage``
    What is done to a file: truncated, bits changed, emptied, a folder in its place, unreadable.
``mutations``
    What somebody else may have written: an entry changed in a file, with a right checksum.
``processes``
    Each case runs in a process of its own, so that a crash is seen; `judge` says what counts as withstood.
``compiled_code``
    The cache of compiled code: every fault leads to the same run.
``stored_files``
    Files of runs and of sweeps: what is read is the same, or is refused with the path and the cure.
``full_disks``
    All that writes files, on a small disk: what was there is still there, and the error names the path.
``kills``
    Long commands, ended at random moments by SIGKILL, SIGINT or a full disk: the file resumed is the same.
``bad_values``
    Every public name with arguments of wrong types, shapes and sizes: it takes them, or raises on purpose.
"""
