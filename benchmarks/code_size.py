"""Size of packages: files, named numbers and lines of code.

    python -m benchmarks.code_size tracking motion pose_graph registration

A named number is a constant of a module or a default of a `…Settings` class whose value contains
a number. Lines of code are those with tokens other than comments and docstrings. With `--root`
another checkout is counted by the same rules.
"""

from __future__ import annotations

import argparse
import ast
import io
import sys
import tokenize
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
NO_CODE = {
    tokenize.COMMENT, tokenize.NL, tokenize.NEWLINE, tokenize.INDENT, tokenize.DEDENT,
    tokenize.ENDMARKER,
}  # fmt: skip


def named_numbers(tree: ast.Module) -> list[str]:
    """Names of constants and settings whose value contains a number."""
    found = list(_assigned(tree.body, constants=True))
    for node in tree.body:
        if isinstance(node, ast.ClassDef) and node.name.endswith("Settings"):
            found += [f"{node.name}.{name}" for name in _assigned(node.body, constants=False)]
    return found


def _assigned(body: list[ast.stmt], constants: bool) -> Iterator[str]:
    for node in body:
        if not isinstance(node, ast.Assign | ast.AnnAssign) or node.value is None:
            continue
        if not any(_is_number(part) for part in ast.walk(node.value)):
            continue
        targets = node.targets if isinstance(node, ast.Assign) else [node.target]
        for target in targets:
            parts = target.elts if isinstance(target, ast.Tuple) else [target]
            names = [part.id for part in parts if isinstance(part, ast.Name)]
            yield from (name for name in names if name.isupper() or not constants)


def _is_number(node: ast.AST) -> bool:
    return (
        isinstance(node, ast.Constant)
        and isinstance(node.value, int | float)
        and not isinstance(node.value, bool)
    )


def lines_of_code(text: str) -> int:
    """Lines with code, without docstrings."""
    documented: set[int] = set()
    for node in ast.walk(ast.parse(text)):
        value = node.value if isinstance(node, ast.Expr) else None
        if isinstance(value, ast.Constant) and isinstance(value.value, str):
            documented |= set(range(value.lineno, (value.end_lineno or value.lineno) + 1))
    lines: set[int] = set()
    for token in tokenize.generate_tokens(io.StringIO(text).readline):
        if token.type not in NO_CODE:
            lines |= set(range(token.start[0], token.end[0] + 1)) - documented
    return len(lines)


def main() -> int:
    """Print a table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("packages", nargs="+", help="names of packages, such as tracking")
    parser.add_argument("--root", type=Path, default=ROOT, help="root of the checkout")
    parser.add_argument("--names", action="store_true", help="list the named numbers")
    given = parser.parse_args()
    print(f"{'package':<16}{'files':>6}{'numbers':>9}{'lines':>7}")
    for package in given.packages:
        files = sorted((given.root / "src" / "circumspect" / package).rglob("*.py"))
        texts = [file.read_text(encoding="utf-8") for file in files]
        numbers = [name for text in texts for name in named_numbers(ast.parse(text))]
        lines = sum(map(lines_of_code, texts))
        print(f"{package:<16}{len(files):>6}{len(numbers):>9}{lines:>7}")
        if given.names:
            print("    " + ", ".join(numbers))
    return 0


if __name__ == "__main__":
    sys.exit(main())
