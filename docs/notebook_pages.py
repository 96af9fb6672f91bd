"""Notebooks as pages of the documentation: their text, their code, and what the code gives.

The stored notebooks have no outputs; the documentation build executes them.
"""

from __future__ import annotations

import ast
import base64
import contextlib
import io
import json
import tempfile
from dataclasses import dataclass
from typing import Any

from circumspect.errors import MissingExtraError

RESOLUTION = 80
"""Of figures [dots per inch]."""


@dataclass(frozen=True)
class CellOutput:
    """What a code cell gives.

    Attributes:
        text: Printed text, and the value of a last expression.
        figures: PNG files of the figures that it drew.
    """

    text: str
    figures: tuple[bytes, ...]


def notebook_page(document: str) -> str:
    """A notebook as Markdown, executed; without outputs if a package that it needs is missing.

    Args:
        document: The file's JSON.
    """
    cells = json.loads(document)["cells"]
    try:
        outputs = executed(cells)
    except (ImportError, MissingExtraError):
        outputs = {}
    return "\n\n".join(_shown(cell, outputs.get(index)) for index, cell in enumerate(cells))


def executed(cells: list[dict[str, Any]]) -> dict[int, CellOutput]:
    """Run the code cells in order, in one namespace and in a temporary folder.

    Args:
        cells: Of a notebook.

    Returns:
        Index of each code cell to what it gives.
    """
    import matplotlib as mpl

    mpl.use("Agg")
    names: dict[str, Any] = {}
    outputs = {}
    with tempfile.TemporaryDirectory() as folder, contextlib.chdir(folder):
        for index, cell in enumerate(cells):
            if cell["cell_type"] == "code":
                outputs[index] = _run("".join(cell["source"]), f"cell {index}", names)
    return outputs


def _run(source: str, name: str, names: dict[str, Any]) -> CellOutput:
    """Execute one cell; a last expression is shown as in Jupyter."""
    tree = ast.parse(source)
    last = tree.body.pop() if tree.body and isinstance(tree.body[-1], ast.Expr) else None
    printed = io.StringIO()
    with contextlib.redirect_stdout(printed):
        exec(compile(tree, name, "exec"), names)
        if isinstance(last, ast.Expr):
            value = eval(compile(ast.Expression(last.value), name, "eval"), names)
            if value is not None:
                print(repr(value))
    return CellOutput(printed.getvalue().rstrip(), _figures())


def _figures() -> tuple[bytes, ...]:
    """All open figures as PNG; they are closed."""
    from matplotlib import pyplot

    drawn = []
    for number in pyplot.get_fignums():
        file = io.BytesIO()
        pyplot.figure(number).savefig(file, format="png", dpi=RESOLUTION)
        drawn.append(file.getvalue())
    pyplot.close("all")
    return tuple(drawn)


def _shown(cell: dict[str, Any], output: CellOutput | None) -> str:
    """A cell as Markdown."""
    source = "".join(cell["source"]).strip()
    if cell["cell_type"] == "markdown":
        return source
    parts = [f"```python\n{source}\n```"]
    if output is not None:
        if output.text:
            parts.append(f"```text\n{output.text}\n```")
        parts += [
            f'<img alt="figure" src="data:image/png;base64,{base64.b64encode(file).decode()}">'
            for file in output.figures
        ]
    return "\n\n".join(parts)
