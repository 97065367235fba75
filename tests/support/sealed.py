"""Results made by hand: sealed as the program seals its own, so that readers believe them."""
import contextlib
import pathlib
import sys

import h5py

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "scripts"))
from surveymc import integrity  # noqa: E402


@contextlib.contextmanager
def result_file(path, mode="w"):
    """h5py.File to write into; sealed behind it."""
    with h5py.File(path, mode) as file:
        yield file
    data = pathlib.Path(path).read_bytes()
    pathlib.Path(path).write_bytes(data + integrity.seal_for(data))
