"""Changes of valid files that keep most of their structure."""

from __future__ import annotations

import random
import re
import struct

EDGES = (0, 1, 0x7F, 0x80, 0xFF, 0x7FFF, 0xFFFF, 2**31 - 1, 2**31, 2**32 - 1, 2**63 - 1, 2**64 - 1)
"""Lengths and counts at which arithmetic overflows."""
WORDS = (
    b"-1", b"0", b"1e999", b"nan", b"true", b"null", b"[]", b"{}", b'""', b"99999999999999999999",
    b"\x00", b"\xff\xfe", b"\x1b[2J", b"../" * 8,
)  # fmt: skip
_NUMBER = re.compile(rb"-?\d+(?:\.\d+)?")
_LARGEST = 16 << 20


def mutated(content: bytes, other: bytes, rng: random.Random) -> bytes:
    """A file with a few changes.

    Args:
        content: A valid file.
        other: Another one; parts of it are inserted.
        rng: Draws the changes.
    """
    changed = bytearray(content)
    for _ in range(rng.choice((1, 1, 2, 4, 8))):
        if not changed:
            break
        rng.choice(_CHANGES)(changed, other, rng)
    return bytes(changed[:_LARGEST])


def _flip(content: bytearray, _: bytes, rng: random.Random) -> None:
    content[rng.randrange(len(content))] ^= 1 << rng.randrange(8)


def _edge(content: bytearray, _: bytes, rng: random.Random) -> None:
    width = rng.choice((1, 2, 4, 8))
    at = _place(content, rng)
    order = rng.choice("<>")
    number = rng.choice(EDGES) & ((1 << 8 * width) - 1)
    content[at : at + width] = (
        struct.pack(f"{order}Q", number)[:width]
        if order == "<"
        else (struct.pack(">Q", number)[-width:])
    )


def _word(content: bytearray, _: bytes, rng: random.Random) -> None:
    numbers = list(_NUMBER.finditer(content[:4096]))
    if numbers:
        number = rng.choice(numbers)
        content[number.start() : number.end()] = rng.choice(WORDS)


def _cut(content: bytearray, _: bytes, rng: random.Random) -> None:
    del content[_place(content, rng) :]


def _remove(content: bytearray, _: bytes, rng: random.Random) -> None:
    at = _place(content, rng)
    del content[at : at + rng.choice((1, 2, 4, 8, 64, 1000))]


def _repeat(content: bytearray, _: bytes, rng: random.Random) -> None:
    at = _place(content, rng)
    part = content[at : at + rng.choice((1, 4, 8, 64, 1000))]
    content[at:at] = part * rng.choice((1, 2, 100))


def _splice(content: bytearray, other: bytes, rng: random.Random) -> None:
    if other:
        begin = rng.randrange(len(other))
        at = _place(content, rng)
        content[at : at + rng.choice((0, 8, 64))] = other[begin : begin + rng.choice((8, 64, 1000))]


def _place(content: bytearray, rng: random.Random) -> int:
    """Anywhere, but half of the time where headers are."""
    end = len(content) if rng.random() < 0.5 else min(len(content), 300)
    return rng.randrange(max(end, 1))


_CHANGES = (_flip, _flip, _edge, _edge, _word, _word, _cut, _remove, _repeat, _splice)
