"""Numbers and lines of code are counted as the page says."""

from __future__ import annotations

import ast

from benchmarks.code_size import lines_of_code, named_numbers

TEXT = '''"""A page of text."""

LIMIT, OTHER = 3, 4.0
NAME = "nothing"
FLAG = True
size: int = 3


class SomeSettings:
    """More text,
    over two lines."""

    # a comment
    width: float = 0.5
    name: str = "x"


def double(x):
    """And more."""
    return 2 * (
        x
    )
'''


def test_numbers_are_those_with_names() -> None:
    assert named_numbers(ast.parse(TEXT)) == ["LIMIT", "OTHER", "SomeSettings.width"]


def test_comments_docstrings_and_empty_lines_are_no_code() -> None:
    assert lines_of_code(TEXT) == 11
