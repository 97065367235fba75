#!/usr/bin/python3
"""Runs the notebooks of docs/, two at a time, each in a temporary folder: test_notebook.py SURVEYMC SOURCE [FOLDER]

FOLDER gets them with what they printed, for the documentation site. Skipped (77) without nbclient.
"""
import concurrent.futures
import os
import pathlib
import sys
import tempfile

try:
    import ipykernel  # noqa: F401
    import nbclient
    import nbformat
except ImportError as error:
    print(f"skipped: not installed: {error.name} (python3-nbclient, python3-nbformat, python3-ipykernel)")
    sys.exit(77)

program, source = os.path.abspath(sys.argv[1]), pathlib.Path(sys.argv[2]).resolve()
os.environ.update(PYDEVD_DISABLE_FILE_VALIDATION="1", SURVEYMC=program, PYTHONPATH=str(source / "scripts"), PYTHONDONTWRITEBYTECODE="1")


def run(path):
    """The notebook with its outputs."""
    notebook = nbformat.read(path, as_version=4)
    nbformat.validate(notebook)
    for cell in notebook.cells:
        if cell.cell_type == "code":
            assert not cell.outputs and cell.execution_count is None, f"{path.name}: kept without outputs: what it prints is made by the reader"
    with tempfile.TemporaryDirectory(prefix="surveymc-notebook-") as folder:
        nbclient.NotebookClient(notebook, timeout=240, resources={"metadata": {"path": folder}}).execute()
        assert not list(pathlib.Path(folder).glob("*.csv")), f"{path.name}: leaves files behind"
    return notebook


def main():
    paths = sorted((source / "docs").rglob("*.ipynb"))
    assert len(paths) >= 5, paths
    with tempfile.TemporaryDirectory(prefix="surveymc-jupyter-") as folder:
        os.environ["JUPYTER_RUNTIME_DIR"] = os.environ["IPYTHONDIR"] = folder
        with concurrent.futures.ProcessPoolExecutor(2) as pool:
            notebooks = dict(zip(paths, pool.map(run, paths)))
    for path, notebook in notebooks.items():
        shown = [output.data for cell in notebook.cells if cell.cell_type == "code" for output in cell.outputs if "data" in output]
        assert any("image/png" in data for data in shown), f"{path.name}: draws nothing"
        if path.name == "python.ipynb":
            assert any("<img" in data.get("text/html", "") for data in shown), "the figures are shown"
        if len(sys.argv) > 3:
            to = pathlib.Path(sys.argv[3]) / path.relative_to(source / "docs")
            to.parent.mkdir(parents=True, exist_ok=True)
            nbformat.write(notebook, to)
        print(f"{path.name}: {len(notebook.cells)} cells, {len(shown)} outputs")


if __name__ == "__main__":
    main()
