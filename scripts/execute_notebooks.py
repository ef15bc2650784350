"""Executes notebooks: `execute_notebooks.py notebooks/a.py ...` writes each one's paired .ipynb, with its outputs.

The same input gives the same file, apart from what the cells themselves print: ids count up, no times are kept.
"""

import os
import sys
from pathlib import Path

import jupytext
import nbclient
import nbformat


def execute(source: Path) -> nbformat.NotebookNode:
    """Runs a notebook from top to bottom in a fresh kernel, in the folder it lies in.

    Raises:
        nbclient.exceptions.CellExecutionError: a cell failed; the message shows it.
    """
    notebook = jupytext.read(source)
    notebook.metadata["kernelspec"] = {"name": "python3", "display_name": "Python 3", "language": "python"}
    for number, cell in enumerate(notebook.cells):
        cell["id"] = f"cell-{number}"
    nbclient.NotebookClient(
        notebook,
        kernel_name="python3",
        record_timing=False,
        timeout=600,
        resources={"metadata": {"path": str(source.parent)}},
    ).execute()
    return notebook


def main(sources: list[str]) -> None:
    for name in sources:
        source = Path(name)
        print(f"executing {source}", flush=True)
        target = source.with_suffix(".ipynb")
        partial = target.with_suffix(".ipynb.partial")
        nbformat.write(execute(source), partial)
        os.replace(partial, target)


if __name__ == "__main__":
    main(sys.argv[1:])
