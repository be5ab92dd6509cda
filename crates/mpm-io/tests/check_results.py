"""Opens a results file with plain h5py and with VTK's own readers, and compares the numbers.

Usage: check_results.py RESULTS.h5      (pip install h5py vtk)
Exits with 0 and a line of counts if everything agrees, else with 1 and the first difference.
"""
import sys
from pathlib import Path

import h5py
import numpy as np
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkIOHDF import vtkHDFReader
from vtkmodules.vtkIOXdmf2 import vtkXdmfReader


def expected(file, step):
    """Positions and fields of one recorded step, by the offsets of the VTKHDF specification."""
    root = file["VTKHDF"]
    steps = root["Steps"]
    n = root["NumberOfPoints"][steps["PartOffsets"][step]]
    first = steps["PointOffsets"][step]
    fields = {}
    for name, values in root["PointData"].items():
        start = steps["PointDataOffsets"][name][step]
        fields[name] = values[start : start + n]
    return root["Points"][first : first + n], fields


def compare(reader, grid, step, points, fields):
    """Every number of one step as VTK shows it."""
    where = f"{reader}, step {step}"
    assert grid.GetNumberOfPoints() == len(points), f"{where}: {grid.GetNumberOfPoints()} points, not {len(points)}"
    assert grid.GetNumberOfCells() == len(points), f"{where}: {grid.GetNumberOfCells()} cells, not {len(points)}"
    for cell in range(0, len(points), max(1, len(points) // 7)):
        assert grid.GetCell(cell).GetPointId(0) == cell, f"{where}: cell {cell} is not vertex {cell}"
    if len(points) == 0:
        return
    np.testing.assert_array_equal(vtk_to_numpy(grid.GetPoints().GetData()), points, err_msg=f"{where}: points")
    for name, values in fields.items():
        array = grid.GetPointData().GetArray(name)
        assert array is not None, f"{where}: no field {name}"
        np.testing.assert_array_equal(vtk_to_numpy(array), values, err_msg=f"{where}: {name}")


def some(n):
    """First, second, middle and last of n steps, and back to the first."""
    return [*sorted({0, min(1, n - 1), n // 2, n - 1}), 0]


def check_vtkhdf(path, file):
    reader = vtkHDFReader()
    reader.SetFileName(str(path))
    reader.UpdateInformation()
    n = int(file["VTKHDF/Steps"].attrs["NSteps"])
    assert reader.GetNumberOfSteps() == n, f"vtkHDFReader sees {reader.GetNumberOfSteps()} steps, not {n}"
    for step in some(n):
        reader.SetStep(step)
        reader.Update()
        assert reader.GetTimeValue() == file["VTKHDF/Steps/Values"][step], f"time of step {step}"
        compare("vtkHDFReader", reader.GetOutputDataObject(0), step, *expected(file, step))
    return n


def check_xdmf(path, file):
    reader = vtkXdmfReader()
    reader.SetFileName(str(path.with_suffix(".xdmf")))
    reader.UpdateInformation()
    key = reader.GetExecutive().TIME_STEPS()
    times = reader.GetOutputInformation(0).Get(key)
    values = file["VTKHDF/Steps/Values"][: int(file["VTKHDF/Steps"].attrs["NSteps"])]
    np.testing.assert_array_equal(times, values, err_msg="times of the XDMF file")
    for step in some(len(times)):
        reader.UpdateTimeStep(times[step])
        output = reader.GetOutputDataObject(0)
        grid = output.GetBlock(0) if output.IsA("vtkMultiBlockDataSet") else output
        compare("vtkXdmfReader", grid, step, *expected(file, step))


def check_history(file):
    """Columns are of one length, and the residuals add up."""
    lengths = {}
    file["history"].visititems(
        lambda name, item: lengths.update({name: len(item)}) if isinstance(item, h5py.Dataset) else None
    )
    assert set(lengths.values()) == {len(file["newton/offset"])}, f"rows differ: {lengths}"
    assert file["newton/offset"][-1] == len(file["newton/residual"]), "residuals do not end at the last offset"
    return len(lengths), len(file["newton/offset"])


def main():
    path = Path(sys.argv[1])
    with h5py.File(path, "r") as file:
        attributes = dict(file.attrs)
        assert attributes["format"] == "mpm-results" and attributes["version"] == 1, f"attributes {attributes}"
        columns, rows = check_history(file)
        steps = check_vtkhdf(path, file)
        check_xdmf(path, file)
    print(f"{path.name}: {columns} columns of {rows} rows, {steps} recorded steps: h5py, VTKHDF and XDMF agree")


if __name__ == "__main__":
    try:
        main()
    except AssertionError as difference:
        sys.exit(f"{sys.argv[1]}: {difference}")
