"""The notebooks run from their first cell to their last, in a kernel of their own."""

from pathlib import Path

import nbformat
import pytest
from nbclient import NotebookClient

NOTEBOOKS = sorted((Path(__file__).parents[1] / "notebooks").glob("*.ipynb"))


@pytest.mark.filterwarnings("default")
@pytest.mark.parametrize("file", NOTEBOOKS, ids=lambda file: file.stem)
def test_a_notebook_runs(file: Path) -> None:
    notebook = nbformat.read(file, as_version=4)
    NotebookClient(notebook, timeout=None, kernel_name="python3").execute()
    cells = [cell for cell in notebook.cells if cell.cell_type == "code"]
    told = [output for cell in cells for output in cell.outputs]
    assert not [output.text for output in told if output.output_type == "stream" and output.name == "stderr"]
    shown = [output.data for output in told if "data" in output]
    assert any("image/png" in data for data in shown)
    if any(cell.source.rstrip().endswith("\nrun") for cell in cells):
        assert any("<iframe" in data.get("text/html", "") for data in shown)


def test_there_are_notebooks() -> None:
    assert len(NOTEBOOKS) == 4
