"""Loops and branches in LLVM's instructions, whose values are passed from hand to hand."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

Values = list[Any]


def repeat(build: Any, count: Any, carried: Values, body: Callable[[Any, Values], Values]) -> Values:
    """Write `carried = body(i, carried)` for i from 0 to `count` - 1; returns what it is in the end."""
    before, inside, after = _blocks(build)
    zero, one = count.type(0), count.type(1)
    build.cbranch(build.icmp_signed("<", zero, count), inside, after)
    build.position_at_end(inside)
    i = build.phi(count.type)
    i.add_incoming(zero, before)
    inner = [_phi(build, (value, before)) for value in carried]
    results = body(i, inner)
    end, following = build.block, build.add(i, one)
    for phi, result in zip([i, *inner], [following, *results], strict=True):
        phi.add_incoming(result, end)
    build.cbranch(build.icmp_signed("<", following, count), inside, after)
    build.position_at_end(after)
    return [_phi(build, (old, before), (new, end)) for old, new in zip(carried, results, strict=True)]


def repeat_while(
    build: Any, goes_on: Any, carried: Values, body: Callable[[Values], tuple[Values, Any]]
) -> Values:
    """Write `carried, goes_on = body(carried)` while `goes_on`; returns what is carried in the end."""
    before, inside, after = _blocks(build)
    build.cbranch(goes_on, inside, after)
    build.position_at_end(inside)
    inner = [_phi(build, (value, before)) for value in carried]
    results, goes_on = body(inner)
    end = build.block
    for phi, result in zip(inner, results, strict=True):
        phi.add_incoming(result, end)
    build.cbranch(goes_on, inside, after)
    build.position_at_end(after)
    return [_phi(build, (old, before), (new, end)) for old, new in zip(carried, results, strict=True)]


def choose(build: Any, condition: Any, yes: Callable[[], Values], no: Callable[[], Values]) -> Values:
    """Write `yes() if condition else no()`; what is not wanted is not computed."""
    inside, other, after = (build.append_basic_block() for _ in range(3))
    build.cbranch(condition, inside, other)
    incoming = []
    for block, values in (inside, yes), (other, no):
        build.position_at_end(block)
        incoming.append([(value, build.block) for value in values()])
        build.branch(after)
    build.position_at_end(after)
    return [_phi(build, *pair) for pair in zip(*incoming, strict=True)]


def _blocks(build: Any) -> tuple[Any, Any, Any]:
    return build.block, build.append_basic_block(), build.append_basic_block()


def _phi(build: Any, *incoming: tuple[Any, Any]) -> Any:
    phi = build.phi(incoming[0][0].type)
    for value, block in incoming:
        phi.add_incoming(value, block)
    return phi
