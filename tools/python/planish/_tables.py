"""Tables of two columns, as text and for notebooks."""

from __future__ import annotations

import html
from typing import Iterable, Union

Rows = Iterable[tuple[str, Union[str, int, float]]]


def show(value: Union[str, int, float]) -> str:
    """Return the text of a value in a table."""
    return f"{value:.4g}" if isinstance(value, float) else str(value)


def text_table(rows: Rows) -> str:
    """Return rows of names and values as aligned lines."""
    shown = [(name, show(value)) for name, value in rows]
    left = max(len(name) for name, _ in shown)
    right = max(len(value) for _, value in shown)
    return "\n".join(f"{name:<{left}}  {value:>{right}}" for name, value in shown)


def html_table(rows: Rows) -> str:
    """Return rows of names and values as a table of HTML."""
    cells = "".join(f'<tr><th style="text-align:left">{html.escape(name)}</th>'
                    f'<td style="text-align:right">{html.escape(show(value))}</td></tr>' for name, value in rows)
    return f"<table>{cells}</table>"
