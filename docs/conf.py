"""How Sphinx builds the documentation: `make docs`."""

from __future__ import annotations

import re
import sys
from importlib import metadata
from pathlib import Path

from myst_parser.parsers.sphinx_ import MystParser

sys.path.insert(0, str(Path(__file__).resolve().parent))
from command_help import add_command_help
from notebook_pages import notebook_page

project = "circumspect"
author = "the circumspect developers"
release = version = metadata.version("circumspect")

extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "sphinx.ext.autosummary",
    "sphinx-mathjax-offline",
    "sphinx.ext.napoleon",
]
exclude_patterns = ["_build"]
myst_enable_extensions = ["dollarmath"]
myst_heading_anchors = 4

html_theme = "furo"
html_title = f"circumspect {release}"
html_show_copyright = False

# Docstrings have names in single backticks, as in Markdown: they become cross references.
default_role = "py:obj"
autodoc_member_order = "bysource"
autodoc_default_options = {"members": True, "imported-members": True, "show-inheritance": True}
autosummary_generate = False
napoleon_use_ivar = True
python_use_unqualified_type_names = True
python_maximum_signature_line_length = 88
# A shape such as (height, width) before a property's text is taken for its type, and several
# classes have a height.
suppress_warnings = ["ref.python"]

DOCS = Path(__file__).resolve().parent
RESULT = re.compile(r"\]\((?:\.\./)+(benchmarks/results/(?:\w+/)?\w+\.md)\)")
MARKUP = re.compile(r"(?<!\\)[*|]")
GLUED = re.compile(r"^(?=\w)")
ARRAY = re.compile(
    r"~?numpy\.ndarray\[tuple\[~?(?:typing\.)?Any, \.\.\.\], "
    r"~?numpy\.dtype\[([^\[\]]+(?:\[.*?\])?)\]\]"
)
CODE = re.compile(r"(`[^`]*`)")


def plain(_app, _what, _name, _object, _options, lines: list[str]) -> None:
    """Stars and bars in docstrings are those of arguments and of formulas, never markup."""
    for number, line in enumerate(lines):
        parts = CODE.split(line)
        parts[::2] = [MARKUP.sub(r"\\\g<0>", part) for part in parts[::2]]
        # A name may be followed by anything, as `sigma`² is.
        parts[2::2] = [GLUED.sub(r"\\ ", part) for part in parts[2::2]]
        lines[number] = "".join(parts)


def short_types(_app, _what, _name, _object, _options, lines: list[str]) -> None:
    """Arrays as they are written in the code; np.str_ ends in what would be a link's mark."""
    for number, line in enumerate(lines):
        lines[number] = re.sub(r"(?<=\w)_(?!\w)", r"\_", as_written(line))


def short_signature(_app, _what, _name, _object, _options, arguments, returned):
    """The same for arguments; a default that a factory makes is shown as `...`."""
    if arguments is not None:
        arguments = as_written(arguments).replace("<factory>", "...")
    return arguments, None if returned is None else as_written(returned)


def as_written(types: str) -> str:
    """NDArray instead of what it stands for."""
    return ARRAY.sub(r"~numpy.typing.NDArray[\1]", types)


def to_benchmarks(link: re.Match[str]) -> str:
    """A result of its own on the forge, a section of the benchmark page here."""
    title = (DOCS.parent / link[1]).read_text(encoding="utf-8").splitlines()[0].lstrip("# ")
    anchor = re.sub(r"[^\w -]", "", title.lower()).replace(" ", "-")
    return f"](/benchmarks.md#{anchor})"


def forge_links(_app, _name, text: list[str]) -> None:
    """Links that lead out of the docs on the forge stay within them here."""
    text[0] = RESULT.sub(to_benchmarks, text[0])


class NotebookParser(MystParser):
    """Shows a notebook as its text, its code and what the code gives."""

    supported = ("notebook",)

    def parse(self, inputstring: str, document) -> None:
        """Parse the executed cells as one page of Markdown."""
        super().parse(notebook_page(inputstring), document)


def setup(app) -> None:
    """Join in where docstrings and pages are read."""
    app.add_source_suffix(".ipynb", "notebook")
    app.add_source_parser(NotebookParser)
    app.connect("source-read", add_command_help)
    app.connect("autodoc-process-docstring", plain, priority=400)
    app.connect("autodoc-process-docstring", short_types, priority=900)
    app.connect("autodoc-process-signature", short_signature)
    app.connect("source-read", forge_links)
