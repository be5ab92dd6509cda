"""Reads a results file: python read.py stretch.h5"""
import sys

import h5py

with h5py.File(sys.argv[1]) as file:
    print("status:", file.attrs["status"])
    history = file["history"]
    rows = history.attrs["rows"]  # Complete rows; row 0 is the initial state.
    load = history["load_fraction"][:rows]
    for name, reaction in history["reaction"].items():
        largest = abs(reaction[:rows]).max(axis=0)
        print(f"reaction of {name}: at most", " ".join(f"{value:.4f}" for value in largest))
    print(f"load fraction {load[-1]:g} after {rows - 1} load steps")

    # Points of all recorded steps lie one after the other.
    vtk = file["VTKHDF"]
    first, count = vtk["Steps/PointOffsets"][-1], vtk["NumberOfPoints"][-1]
    points = vtk["Points"][first : first + count]
    print(f"{count} points between {points.min(axis=0)} and {points.max(axis=0)}")
    for name, values in vtk["PointData"].items():
        print(f"{name}: {values[first : first + count].min():.4g} to {values[first : first + count].max():.4g}")
