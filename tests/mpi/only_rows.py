"""only_rows.py BEFORE.h5 AFTER.h5: files that differ in the bytes of geometry/vertices, and in no others."""
import sys

import h5py
import numpy


def place(path):
    with h5py.File(path) as file:
        data = file["geometry/vertices"]
        where = data.id.get_chunk_info(0).byte_offset if data.chunks else data.id.get_offset()
        return where, data.id.get_storage_size()


def main():
    before, after = (numpy.fromfile(path, dtype=numpy.uint8) for path in sys.argv[1:])
    where, size = place(sys.argv[1])
    assert len(before) == len(after), "length"
    different = numpy.nonzero(before != after)[0]
    assert len(different) > 0, "nothing has moved"
    assert different[0] >= where and different[-1] < where + size, "bytes of something else"


main()
