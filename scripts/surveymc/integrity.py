"""Is a result file what the program wrote? Its last bytes are a seal: a mark and a hash of all bytes before
(docs/results-format.md). HDF5 follows damaged addresses and crashes, so the seal is looked at before HDF5 opens the file. A
file without a seal (rewritten by h5repack, extended by h5py) is held against the content hash that it carries."""

import os
import struct

import h5py
import numpy as np
import xxhash

MARK = b"SMCSEAL2"
PAGE = 1 << 16
SEAL_SIZE = len(MARK) + 16


def _end_of_hdf5(head):
    """Where the data of HDF5 end by the superblock at the begin of a file, whose addresses have 8 bytes; None if unknown."""
    at = {0: 40, 1: 44, 2: 28, 3: 28}.get(head[8]) if head.startswith(b"\x89HDF\r\n\x1a\n") and len(head) >= 52 else None
    return None if at is None else struct.unpack_from("<Q", head, at)[0]


def seal_of(path):
    """True if the file has the right seal, False if a wrong one or a part of one, None if it has none."""
    size = os.path.getsize(path)
    with open(path, "rb") as file:
        end = _end_of_hdf5(file.read(64))
        seal = b""
        if size >= SEAL_SIZE:
            file.seek(size - SEAL_SIZE)
            seal = file.read(SEAL_SIZE)
        if not seal.startswith(MARK):
            return None if end is None or size <= end else False
        file.seek(0)
        state, left = xxhash.xxh3_128(), size - SEAL_SIZE
        while left > 0:
            page = file.read(min(left, PAGE))
            if not page:
                return False
            state.update(xxhash.xxh3_128_digest(page))
            left -= len(page)
    return seal[len(MARK):] == state.digest()


def seal_for(data):
    """The seal for these bytes."""
    pages = (xxhash.xxh3_128_digest(data[at:at + PAGE]) for at in range(0, len(data), PAGE))
    return MARK + xxhash.xxh3_128_digest(b"".join(pages))


class _Hasher:
    """XXH3-128 over values that follow each other, every list and text behind its length (lib/store/content_hash.cpp)."""

    def __init__(self):
        self._state = xxhash.xxh3_128()

    def number(self, x):
        self._state.update(struct.pack("<Q", x))

    def texts(self, *texts):
        for text in texts:
            data = text.encode("utf-8")
            self.number(len(data))
            self._state.update(data)

    def raw(self, values):
        self._state.update(np.ascontiguousarray(values).tobytes())

    def values(self, dataset, kinds):
        """The place of its type in `kinds`, then the list."""
        if h5py.check_string_dtype(dataset.dtype) is not None:
            words = dataset.asstr()[()]
            self.number(kinds.index("text"))
            self.number(len(words))
            self.texts(*words)
            return
        kind = "real" if dataset.dtype.kind == "f" else "integer"
        self.number(kinds.index(kind))
        self.number(len(dataset))
        self.raw(dataset[()])

    def hex(self):
        return self._state.hexdigest()


def _text(item, key, otherwise=""):
    value = item.attrs.get(key, otherwise)
    return value.decode("utf-8") if isinstance(value, bytes) else str(value)


def _links(group):
    """Names in a group, in the order in which they were written. ValueError if one leads elsewhere, or has its values there:
    into another file, or other datasets. surveymc writes nothing of the kind."""
    names = []
    group.id.links.iterate(lambda name: names.append(name.decode("utf-8")), idx_type=h5py.h5.INDEX_CRT_ORDER)
    for name in names:
        if not isinstance(group.get(name, getlink=True), h5py.HardLink):
            raise ValueError(f"{name} leads elsewhere")
        item = group[name]
        if isinstance(item, h5py.Dataset) and (item.is_virtual or item.external):
            raise ValueError(f"{name} has its values elsewhere")
    return names


def _columns(h, group):
    names = [name for name in _links(group) if name != "row"]
    h.number(len(names))
    for name in names:
        column = group[name]
        h.texts(_text(column, "original_name", name), _text(column, "units"), _text(column, "long_name"),
                _text(column, "ancillary_variables"))
        h.values(column, ("real", "integer", "text"))


def _tables(h, group):
    names = _links(group)
    h.number(len(names))
    for name in names:
        h.texts(name, _text(group[name], "long_name"))
        _columns(h, group[name])


def _map_hash(name, dataset):
    h = _Hasher()
    h.texts(name, _text(dataset, "units"), _text(dataset, "long_name"))
    h.number(dataset.ndim)
    for dimension in dataset.dims:
        axis = dimension[0]
        h.texts(_text(axis, "original_name", axis.name.rsplit("/", 1)[-1]), _text(axis, "units"), _text(axis, "long_name"))
        h.values(axis, ("real", "text"))
    h.number(dataset.size)
    for piece in dataset if dataset.ndim else [dataset[()]]:
        h.raw(piece)
    return h.hex()


def content_hash(file):
    """The hash of tables, samples, maps, inputs and provenance of an open result; equal to its attribute `content_hash`."""
    _links(file)
    _links(file["maps"])
    h = _Hasher()
    h.texts("surveymc result 1", *(_text(file, key) for key in ("title", "experiment", "config", "config_hash")))
    h.number(int(file.attrs["seed"]))
    h.number(int(file.attrs["trials"]))
    _tables(h, file["tables"])
    _tables(h, file["samples"])
    maps = {name: item for name, item in file["maps"].items() if not h5py.h5ds.is_scale(item.id)}
    h.number(len(maps))
    for name in sorted(maps, key=lambda name: name.encode("utf-8")):
        h.texts(name, _map_hash(name, maps[name]))
    inputs = _links(file["inputs"])
    h.number(len(inputs))
    for name in inputs:
        group = file["inputs"][name]
        h.texts(_text(group, "path"), _text(group, "hash"), _text(group, "long_name"))
        _columns(h, group)
    return h.hex()
