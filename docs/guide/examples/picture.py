"""Draws the last step of a results file: python picture.py stretch.h5 picture.png"""
import sys

import numpy as np
import pyvista as pv

reader = pv.HDFReader(sys.argv[1])
reader.reader.UpdateInformation()
reader.reader.SetStep(reader.reader.GetNumberOfSteps() - 1)
points = reader.read()

# Tensors have nine components; the norm of the deviator is what yields.
stress = points["cauchy_stress"].reshape(-1, 3, 3)
deviator = stress - np.trace(stress, axis1=1, axis2=2)[:, None, None] / 3 * np.eye(3)
points["deviatoric stress"] = np.linalg.norm(deviator, axis=(1, 2))

plotter = pv.Plotter(off_screen=True, window_size=(800, 600))
plotter.add_mesh(points, scalars="deviatoric stress", point_size=14, render_points_as_spheres=True)
plotter.view_xy()
plotter.screenshot(sys.argv[2])
print(f"{points.n_points} points at load fraction {reader.reader.GetTimeValue():g}")
