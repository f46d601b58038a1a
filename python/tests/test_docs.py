"""The page and the notebooks run as they stand."""

from __future__ import annotations

import contextlib
import io
import re
from pathlib import Path

import nbformat
import pytest
from conftest import TOP
from nbclient import NotebookClient

PAGES = [TOP / "docs" / "python.md", TOP / "python" / "README.md"]
NOTEBOOKS = sorted((TOP / "docs").glob("*.ipynb"))


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_the_examples_of_a_page_run_and_print_what_it_says(
    page: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Blocks of Python run in order in one namespace; a block of text below one is what it prints."""
    (tmp_path / "tests").symlink_to(TOP / "tests")
    monkeypatch.chdir(tmp_path)
    blocks = re.findall(r"^```(\w+)\n(.*?)^```", page.read_text(), re.MULTILINE | re.DOTALL)
    assert any(kind == "python" for kind, _ in blocks)
    names: dict[str, object] = {"__name__": "__main__"}
    for (kind, code), (below, printed) in zip(blocks, [*blocks[1:], ("", "")]):
        if kind != "python":
            continue
        out = io.StringIO()
        with contextlib.redirect_stdout(out):
            exec(compile(code, str(page), "exec"), names)
        if below == "text":
            assert out.getvalue().rstrip() == printed.rstrip(), code


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.name)
def test_a_notebook_runs_from_top_to_bottom(path: Path, tmp_path: Path) -> None:
    (tmp_path / "tests").symlink_to(TOP / "tests")
    notebook = nbformat.read(path, as_version=4)
    NotebookClient(notebook, timeout=300, resources={"metadata": {"path": str(tmp_path)}}).execute()
    shown = [
        output
        for cell in notebook.cells
        if cell.cell_type == "code"
        for output in cell.outputs
        if output.output_type in ("execute_result", "display_data")
    ]
    assert any("text/html" in output.data for output in shown)
    assert any("image/png" in output.data for output in shown)


def test_there_is_a_notebook() -> None:
    assert NOTEBOOKS
