#!/usr/bin/python3
"""Runs docs/tutorials/python.ipynb, in a temporary folder: test_notebook.py SURVEYMC SOURCE. Skipped (77) without nbclient."""
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
notebook = nbformat.read(source / "docs/tutorials/python.ipynb", as_version=4)
nbformat.validate(notebook)
for cell in notebook.cells:
    if cell.cell_type == "code":
        assert not cell.outputs and cell.execution_count is None, "kept without outputs: what it prints is made by the reader"
with tempfile.TemporaryDirectory(prefix="surveymc-notebook-") as folder:
    os.environ["JUPYTER_RUNTIME_DIR"] = os.environ["IPYTHONDIR"] = folder
    nbclient.NotebookClient(notebook, timeout=120, resources={"metadata": {"path": folder}}).execute()
    assert not os.path.exists(os.path.join(folder, "notebook_well.csv"))
shown = [output.data for cell in notebook.cells if cell.cell_type == "code" for output in cell.outputs if "data" in output]
assert any("image/png" in data for data in shown), "the ellipse is drawn"
assert any("<img" in data.get("text/html", "") for data in shown), "the figures are shown"
print(f"{len(notebook.cells)} cells, {len(shown)} outputs")
