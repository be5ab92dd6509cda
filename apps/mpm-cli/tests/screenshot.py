"""Draws a file with VTK's own reader, without a screen, and says what the picture shows.

Usage: screenshot.py RESULTS.h5|DOMAINS.vtu PICTURE.png      (pip install vtk)
Prints the area that is not background, its bounds, all in units of the file, and the number of colours. Exits with 77
and a reason where this machine cannot draw.
"""
import sys

import numpy as np
import vtkmodules.vtkRenderingOpenGL2  # noqa: F401, what draws
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkIOHDF import vtkHDFReader
from vtkmodules.vtkIOImage import vtkPNGWriter
from vtkmodules.vtkIOXML import vtkXMLUnstructuredGridReader
from vtkmodules.vtkRenderingCore import (
    vtkActor,
    vtkDataSetMapper,
    vtkRenderer,
    vtkRenderWindow,
    vtkWindowToImageFilter,
)

SIZE = 600  # pixels


def grid(path):
    if path.endswith(".vtu"):
        reader = vtkXMLUnstructuredGridReader()
        reader.SetFileName(path)
        reader.Update()
        return reader.GetOutput()
    reader = vtkHDFReader()
    reader.SetFileName(path)
    reader.UpdateInformation()
    reader.SetStep(reader.GetNumberOfSteps() - 1)
    reader.Update()
    return reader.GetOutputDataObject(0)


def window():
    """A window that needs no screen."""
    window = vtkRenderWindow()
    window.SetOffScreenRendering(True)
    if not window.SupportsOpenGL():
        try:
            from vtkmodules.vtkRenderingOpenGL2 import vtkOSOpenGLRenderWindow
        except ImportError:
            print("neither a display nor OSMesa")
            sys.exit(77)
        window = vtkOSOpenGLRenderWindow()
    window.SetSize(SIZE, SIZE)
    window.SetMultiSamples(0)
    return window


def main():
    body = grid(sys.argv[1])
    mapper = vtkDataSetMapper()
    mapper.SetInputData(body)
    if body.GetCellData().HasArray("cauchy_stress"):
        mapper.SetScalarModeToUseCellFieldData()
    else:
        mapper.SetScalarModeToUsePointFieldData()
    mapper.SelectColorArray("cauchy_stress")
    mapper.SetArrayComponent(4)  # yy
    values = body.GetCellData().GetArray("cauchy_stress") or body.GetPointData().GetArray("cauchy_stress")
    mapper.SetScalarRange(values.GetRange(4))
    actor = vtkActor()
    actor.SetMapper(mapper)
    actor.GetProperty().LightingOff()
    actor.GetProperty().SetPointSize(5)

    renderer = vtkRenderer()
    renderer.SetBackground(1, 1, 1)
    renderer.AddActor(actor)
    x0, x1, y0, y1, _, _ = body.GetBounds()
    centre, half = ((x0 + x1) / 2, (y0 + y1) / 2), 0.6 * max(x1 - x0, y1 - y0)
    camera = renderer.GetActiveCamera()
    camera.ParallelProjectionOn()
    camera.SetFocalPoint(*centre, 0)
    camera.SetPosition(*centre, 1)
    camera.SetParallelScale(half)
    renderer.ResetCameraClippingRange()
    shown = window()
    shown.AddRenderer(renderer)
    shown.Render()

    picture = vtkWindowToImageFilter()
    picture.SetInput(shown)
    picture.ReadFrontBufferOff()
    picture.Update()
    writer = vtkPNGWriter()
    writer.SetFileName(sys.argv[2])
    writer.SetInputConnection(picture.GetOutputPort())
    writer.Write()
    pixels = vtk_to_numpy(picture.GetOutput().GetPointData().GetScalars()).reshape(SIZE, SIZE, -1)
    coloured = (pixels != 255).any(axis=2)
    rows, columns = np.nonzero(coloured)
    pixel = 2 * half / SIZE
    area = coloured.sum() * pixel**2
    at = [
        centre[0] - half + columns.min() * pixel,
        centre[0] - half + (columns.max() + 1) * pixel,
        centre[1] - half + rows.min() * pixel,
        centre[1] - half + (rows.max() + 1) * pixel,
    ]
    colours = len(np.unique(pixels[coloured], axis=0))
    print(area, *at, colours)


main()
