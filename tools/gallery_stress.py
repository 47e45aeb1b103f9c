#!/usr/bin/env python3
"""Draws the stress of docs/gallery.md: a block of bone, pressed by 1 % along x, in CalculiX.

usage: gallery_stress.py FOLDER PICTURE

FOLDER holds bone-block.inp and bone-block.vtu, made as that page says. Needs ccx (Debian
calculix-ccx), and numpy and vtk from PyPI.
"""

import pathlib
import subprocess
import sys

import numpy
import vtk
from vtk.util import numpy_support

STEP = """*INCLUDE, INPUT=bone-block.inp
*BOUNDARY
X_MIN, 1, 3, 0
X_MAX, 1, 1, -0.306
X_MAX, 2, 3, 0
*STEP
*STATIC
*EL FILE
S
*END STEP
"""


def stresses(path, count):
    """The six components at each node."""
    values, is_stress = numpy.zeros((count, 6)), False
    for line in path.read_text().splitlines():
        if line.startswith(" -4"):
            is_stress = line.split()[1] == "STRESS"
        elif line.startswith(" -3"):
            is_stress = False
        elif line.startswith(" -1") and is_stress:
            node = int(line[3:13]) - 1
            values[node] = [float(line[i:i + 12]) for i in range(13, 13 + 6 * 12, 12)]
    return values


def von_mises(s):
    x, y, z, xy, yz, zx = s.T
    return numpy.sqrt(((x - y) ** 2 + (y - z) ** 2 + (z - x) ** 2) / 2
                      + 3 * (xy ** 2 + yz ** 2 + zx ** 2))


def draw(mesh, picture):
    colors = vtk.vtkLookupTable()
    colors.SetHueRange(2 / 3, 0)
    colors.Build()
    mapper = vtk.vtkDataSetMapper()
    mapper.SetInputData(mesh)
    mapper.SetScalarRange(0, 100)
    mapper.SetLookupTable(colors)
    block = vtk.vtkActor()
    block.SetMapper(mapper)
    block.GetProperty().EdgeVisibilityOn()
    scale = vtk.vtkScalarBarActor()
    scale.SetLookupTable(colors)
    scale.SetTitle("von Mises, MPa")
    scale.SetUnconstrainedFontSize(True)
    scale.SetNumberOfLabels(3)
    scale.SetLabelFormat("{:.0f}" if vtk.vtkVersion.GetVTKMajorVersion() > 9 else "%.0f")
    scale.SetPosition(0.86, 0.3)
    scale.SetWidth(0.1)
    scale.SetHeight(0.4)
    for text in (scale.GetTitleTextProperty(), scale.GetLabelTextProperty()):
        text.SetColor(0, 0, 0)
        text.SetFontSize(13)
        text.ItalicOff()
        text.ShadowOff()
    scene = vtk.vtkRenderer()
    scene.AddActor(block)
    scene.AddViewProp(scale)
    scene.SetBackground(1, 1, 1)
    window = vtk.vtkRenderWindow()
    window.SetOffScreenRendering(1)
    window.SetSize(680, 480)
    window.AddRenderer(scene)
    scene.ResetCamera()
    camera = scene.GetActiveCamera()
    camera.Azimuth(35)
    camera.Elevation(25)
    scene.ResetCamera()
    camera.Zoom(1.25)
    window.Render()
    pixels = vtk.vtkWindowToImageFilter()
    pixels.SetInput(window)
    writer = vtk.vtkPNGWriter()
    writer.SetCompressionLevel(9)
    writer.SetFileName(str(picture))
    writer.SetInputConnection(pixels.GetOutputPort())
    writer.Write()


def main():
    folder, picture = map(pathlib.Path, sys.argv[1:])
    (folder / "press.inp").write_text(STEP)
    subprocess.run(["ccx", "press"], cwd=folder, check=True, stdout=subprocess.DEVNULL)
    reader = vtk.vtkXMLUnstructuredGridReader()
    reader.SetFileName(str(folder / "bone-block.vtu"))
    reader.Update()
    mesh = reader.GetOutput()
    values = von_mises(stresses(folder / "press.frd", mesh.GetNumberOfPoints()))
    array = numpy_support.numpy_to_vtk(values, deep=True)
    array.SetName("von Mises")
    mesh.GetPointData().SetScalars(array)
    draw(mesh, picture)


if __name__ == "__main__":
    main()
