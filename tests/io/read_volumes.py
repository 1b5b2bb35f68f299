"""Reads volumes with programs that know nothing of kappamu and says where their marker lies.

usage: read_volumes.py vdb|vti|vol|npy FILE...

One line per volume: name, voxels along x y z, the marker's centre in mm, its value, and the value
of all other voxels. The marker is the one voxel that differs from the others.
"""
import json
import os
import sys

import numpy


def report(name, array_zyx, world):
    """world(i, j, k) gives the centre of a voxel [mm]."""
    values, counts = numpy.unique(array_zyx, return_counts=True)
    if len(values) != 2 or counts.min() != 1:
        print(f"{name}: no single marker, {len(values)} different values")
        return
    marker = values[counts.argmin()]
    k, j, i = (int(n[0]) for n in numpy.where(array_zyx == marker))
    x, y, z = world(i, j, k)
    nz, ny, nx = array_zyx.shape
    print(f"{name} {nx}x{ny}x{nz} at {x:.4f} {y:.4f} {z:.4f} is {marker:.5g} in "
          f"{values[counts.argmax()]:.5g}")


def read_vdb(file):
    import pyopenvdb
    grids, metadata = pyopenvdb.readAll(file)
    for grid in sorted(grids, key=lambda g: g.name):
        lower, upper = grid.evalActiveVoxelBoundingBox()
        shape = tuple(u - l + 1 for l, u in zip(lower, upper))
        assert grid.activeVoxelCount() == numpy.prod(shape)
        assert grid.gridClass == pyopenvdb.GridClass.FOG_VOLUME
        xyz = numpy.empty(shape, dtype=numpy.float32)
        grid.copyToArray(xyz, ijk=lower)
        report(f"{grid.name} [{grid['units']}]", xyz.transpose(2, 1, 0),
               lambda i, j, k: grid.transform.indexToWorld((i, j, k)))
    print("eta", metadata["eta"], "session", metadata["provenance_session"])


def read_vti(file):
    from vtkmodules.util.numpy_support import vtk_to_numpy
    from vtkmodules.vtkIOXML import vtkXMLImageDataReader
    reader = vtkXMLImageDataReader()
    reader.SetFileName(file)
    reader.Update()
    image = reader.GetOutput()
    nx, ny, nz = (n - 1 for n in image.GetDimensions())

    def world(i, j, k):
        bounds = image.GetCell((k * ny + j) * nx + i).GetBounds()
        return [(bounds[2 * a] + bounds[2 * a + 1]) / 2 for a in range(3)]

    data = image.GetCellData()
    assert image.GetPointData().GetNumberOfArrays() == 0
    for a in range(data.GetNumberOfArrays()):
        values = vtk_to_numpy(data.GetArray(a))
        report(data.GetArrayName(a), values.reshape(nz, ny, nx), world)
    field = image.GetFieldData()
    print("eta", field.GetAbstractArray("eta").GetValue(0), "session",
          field.GetAbstractArray("provenance_session").GetValue(0))


def read_vol(file):
    raw = open(file, "rb").read()
    assert raw[:4] == b"VOL\x03"
    encoding, nx, ny, nz, channels = numpy.frombuffer(raw, "<i4", 5, 4)
    assert encoding == 1 and len(raw) == 48 + 4 * nx * ny * nz * channels
    box = numpy.frombuffer(raw, "<f4", 6, 24)
    data = numpy.frombuffer(raw, "<f4", offset=48).reshape(nz, ny, nx, channels)

    def world(i, j, k):
        return box[:3] + (numpy.array([i, j, k]) + 0.5) * (box[3:] - box[:3]) / (nx, ny, nz)

    for c in range(channels):
        report(f"{os.path.basename(file)} {c}", data[..., c], world)


def read_npy(file):
    array = numpy.load(file)
    assert array.dtype == numpy.float32 and array.flags["C_CONTIGUOUS"]
    header = json.load(open(os.path.join(os.path.dirname(file), "volume.json")))
    assert header["grid"] == list(array.shape[::-1])
    name = os.path.splitext(os.path.basename(file))[0]
    report(f"{name} [{header['units'][name]}]", array,
           lambda i, j, k: [(n + 0.5) * header["voxel_mm"] for n in (i, j, k)])


readers = {"vdb": read_vdb, "vti": read_vti, "vol": read_vol, "npy": read_npy}
for path in sys.argv[2:]:
    readers[sys.argv[1]](path)
