"""Elementary functions with the same bits on every machine.

C's mathematical library gives different last digits on different machines, and so do fused multiply-adds.
These functions only add, multiply, divide, take square roots and look at the bits of numbers.  IEEE 754
fixes all of these, so compiled code for any processor and plain Python agree to the last bit.  Each result
is within 0.6 ulp of the exact one, as intermediate results have twice the digits of a number where it
matters.

``double_double``
    Arithmetic on pairs of numbers, each an unevaluated sum with twice the digits; the bits of a number as an
    integer, and powers of two.
``exponentials``
    exp, expm1, sinh, cosh, tanh, 1/cosh^2; log, log1p, asinh, acosh, atanh, and powers.
``trigonometry``
    sin, cos, tan, and atan, asin, acos.

Arguments and results are plain numbers.  Inside a file an argument becomes a pair once and is reduced to a
short interval, on which a series gives the result.  Sources: Dekker, Numer. Math. 18 (1971) 224-242, for
pairs; Payne & Hanek, SIGNUM Newsletter 18 (1983) 19-24, for the reduction of large angles; Muller, Elementary
Functions, 3rd ed. (2016).
"""
