"""Half a second of a probe on a table, as columns and as CSV: right, and with one thing wrong."""

import numpy as np

Columns = dict[str, np.ndarray]

TIME = np.arange(50) * 0.01
WAVE = np.sin(5.0 * TIME)


def good() -> Columns:
    """The least that a contact recording needs, 10 ms apart."""
    columns = {"time": TIME.copy()}
    for i, axis in enumerate("xyz"):
        columns[f"position_{axis}"] = 0.01 * np.sin(5.0 * TIME + i) - 0.005
        columns[f"force_{axis}"] = 0.5 * np.cos(5.0 * TIME + i)
    return columns


def changed(**values: np.ndarray | None) -> Columns:
    """Columns replaced, added, or (None) taken away."""
    return {name: column for name, column in (good() | values).items() if column is not None}


def with_cell(name: str, row: int, value: float) -> Columns:
    """One cell changed; rows count from 1."""
    columns = good()
    columns[name][row - 1] = value
    return columns


def csv_text(columns: Columns) -> str:
    """Columns as CSV."""
    rows = zip(*(values.tolist() for values in columns.values()), strict=True)
    return "\n".join([",".join(columns), *(",".join(map(repr, row)) for row in rows)]) + "\n"
