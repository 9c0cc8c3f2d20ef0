"""The notebooks run, from the wheel alone and without a network."""

from __future__ import annotations

from pathlib import Path

import pytest

nbformat = pytest.importorskip("nbformat")
nbclient = pytest.importorskip("nbclient")

NOTEBOOKS = sorted((Path(__file__).resolve().parents[2] / "examples" / "notebooks").glob("*.ipynb"))


def cases() -> list[object]:
    marked = []
    for path in NOTEBOOKS:
        is_long = nbformat.read(path, as_version=4).metadata["trueweld"]["long"]
        marked.append(pytest.param(path, id=path.stem, marks=[pytest.mark.long] if is_long else []))
    return marked


def printed(notebook: object) -> str:
    outputs = [output for cell in notebook.cells for output in cell.get("outputs", [])]  # type: ignore[attr-defined]
    return "".join(output.text for output in outputs if output.output_type == "stream" and output.name == "stdout")


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("path", cases())
def test_a_notebook_runs_and_prints_what_it_shows(path: Path, tmp_path: Path) -> None:
    shown = nbformat.read(path, as_version=4)
    notebook = nbformat.read(path, as_version=4)
    nbclient.NotebookClient(notebook, timeout=1800, resources={"metadata": {"path": str(tmp_path)}}).execute()
    assert printed(notebook) == printed(shown)
    pictures = [
        output for cell in notebook.cells for output in cell.get("outputs", []) if "image/png" in output.get("data", {})
    ]
    assert pictures, "a notebook has pictures in it"
