"""Reports in the terminal: no Markdown, no line wider than the terminal."""

from __future__ import annotations

import pytest

from circumspect.cli.report_screen import print_report
from circumspect.evaluation.markdown import table

COLUMNS = ["network", *(f"figure {number}" for number in range(14))]
WIDE = table(COLUMNS, [[f"network {row}", *["0.123"] * 14] for row in range(3)])
REPORT = f"""# A comparison

```sh
circumspect reproduce rivals
```

Words that explain `planes` to whoever reads. {"More of them. " * 20}

## The table

{WIDE}

![A picture](picture.png)
"""


@pytest.fixture(autouse=True)
def _terminal(monkeypatch):
    monkeypatch.setenv("COLUMNS", "80")


def test_report_fits_80_columns_and_has_no_markdown(capsys):
    print_report(REPORT)
    lines = capsys.readouterr().out.splitlines()
    assert max(map(len, lines)) <= 80
    assert not any(sign in line for line in lines for sign in ("|", "#", "`", "!["))
    assert lines[0].strip() == "A comparison"
    assert lines[2].strip() == "circumspect reproduce rivals"


def test_wide_table_is_shown_in_parts_that_begin_with_the_first_column(capsys):
    print_report(WIDE)
    lines = capsys.readouterr().out.splitlines()
    heads = [line for line in lines if line.startswith("network  ")]
    assert len(heads) > 1
    assert [word for head in heads for word in head.split() if word.isdecimal()] == [
        str(number) for number in range(14)
    ]
    for row in range(3):
        found = [line for line in lines if line.startswith(f"network {row}")]
        assert len(found) == len(heads)
        assert sum(line.count("0.123") for line in found) == 14


def test_single_column_wider_than_the_terminal_is_wrapped(capsys):
    print_report(table(["name", "what"], [["a", "word " * 40]]))
    lines = capsys.readouterr().out.splitlines()
    assert max(map(len, lines)) <= 80
    assert sum(line.count("word") for line in lines) == 40
