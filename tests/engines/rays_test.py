#!/usr/bin/env python3
"""Sets pictures of rays beside those of VTK, by the same camera, steps and transfer function.

usage: rays_test.py OCTAVO [unittest arguments]

The volume is a phantom. SSIM is that of Wang et al. (2004), of grey values in windows of 7 x 7.
"""

import json
import math
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

import numpy
import vtk
from vtkmodules.util import numpy_support

OCTAVO = ""
SIZE = (96, 88, 80)
SPACING = (1.0, 1.0, 1.5)
PIXELS = 300
AZIMUTH, ELEVATION = 30, 20
POINTS = [(-200, (200, 140, 110), 0), (0, (220, 160, 130), 0.02), (200, (230, 190, 160), 0.02),
          (500, (250, 240, 220), 0.3), (1500, (255, 255, 255), 0.8)]
LOWEST = 0.95


def window_means(image, side=7):
    sums = numpy.cumsum(numpy.cumsum(numpy.pad(image, ((1, 0), (1, 0))), 0), 1)
    return (sums[side:, side:] - sums[:-side, side:] - sums[side:, :-side]
            + sums[:-side, :-side]) / side**2


def ssim(a, b):
    mean_a, mean_b = window_means(a), window_means(b)
    var_a = window_means(a * a) - mean_a**2
    var_b = window_means(b * b) - mean_b**2
    both = window_means(a * b) - mean_a * mean_b
    c1, c2 = (0.01 * 255) ** 2, (0.03 * 255) ** 2
    return numpy.mean((2 * mean_a * mean_b + c1) * (2 * both + c2)
                      / ((mean_a**2 + mean_b**2 + c1) * (var_a + var_b + c2)))


def grey(pixels):
    return pixels.reshape(PIXELS, PIXELS, -1)[:, :, :3].astype(float).mean(2)


def picture_of_file(path):
    reader = vtk.vtkPNGReader()
    reader.SetFileName(str(path))
    reader.Update()
    return grey(numpy_support.vtk_to_numpy(reader.GetOutput().GetPointData().GetScalars()))


class BesideVtk(unittest.TestCase):
    def setUp(self):
        holder = tempfile.TemporaryDirectory()
        self.addCleanup(holder.cleanup)
        self.folder = pathlib.Path(holder.name)
        z, y, x = numpy.indices(SIZE[::-1])
        radius = numpy.sqrt((x - 47) ** 2 + (y - 44) ** 2 + ((z - 40) * 1.5) ** 2)
        bumps = 60 * numpy.sin(x / 5) * numpy.cos(y / 6) * numpy.sin(z / 4)
        values = numpy.clip(900 - 30 * numpy.abs(radius - 24) + bumps, -1000, 3000)
        values[radius < 14] = 150
        values.astype("<i2").tofile(self.folder / "v.raw")
        self.octavo("build", "v.raw", "--raw", ",".join(map(str, SIZE)) + ",int16", "--spacing",
                    ",".join(map(str, SPACING)), "-q", "-o", "v.8vo")
        (self.folder / "t.json").write_text(json.dumps({
            "points": [{"value": v, "color": "#%02x%02x%02x" % c, "opacity": o}
                       for v, c, o in POINTS], "layer_mm": 1}))
        self.values = values.astype(numpy.int16)

    def octavo(self, *arguments):
        return subprocess.run([OCTAVO, *arguments], cwd=self.folder, check=True,
                              stdout=subprocess.PIPE, text=True).stdout

    def draw(self, *options):
        said = json.loads(self.octavo(
            "render", "v.8vo", *options, "--level", "0", "--size", str(PIXELS), "--azimuth",
            str(AZIMUTH), "--elevation", str(ELEVATION), "--no-legend", "--no-sides",
            "--no-scale-bar", "-f", "--json", "-o", "p.png"))
        return picture_of_file(self.folder / "p.png"), said["pixel_mm"]

    def vtk_picture(self, points, pixel_mm, is_mip, body=None):
        image = vtk.vtkImageData()
        image.SetDimensions(*SIZE)
        image.SetSpacing(*SPACING)
        image.GetPointData().SetScalars(numpy_support.numpy_to_vtk(self.values.ravel(), deep=True))
        color, opacity = vtk.vtkColorTransferFunction(), vtk.vtkPiecewiseFunction()
        for value, rgb, alpha in points:
            color.AddRGBPoint(value, *(channel / 255 for channel in rgb))
            opacity.AddPoint(value, alpha)
        look = vtk.vtkVolumeProperty()
        look.SetColor(color)
        look.SetScalarOpacity(opacity)
        look.SetScalarOpacityUnitDistance(1)
        look.SetInterpolationTypeToLinear()
        if not is_mip:
            look.ShadeOn()
            look.SetAmbient(0.22)
            look.SetDiffuse(0.78)
            look.SetSpecular(0.16)
            look.SetSpecularPower(32)
        mapper = vtk.vtkFixedPointVolumeRayCastMapper()
        mapper.SetInputData(image)
        mapper.AutoAdjustSampleDistancesOff()
        mapper.SetImageSampleDistance(1)
        mapper.SetSampleDistance(0.25)
        if is_mip:
            mapper.SetBlendModeToMaximumIntensity()
        volume = vtk.vtkVolume()
        volume.SetMapper(mapper)
        volume.SetProperty(look)
        view = vtk.vtkRenderer()
        view.AddVolume(volume)
        if body:
            view.AddActor(body)
        window = vtk.vtkRenderWindow()
        window.SetOffScreenRendering(1)
        window.SetSize(PIXELS, PIXELS)
        window.AddRenderer(view)
        a, e = math.radians(AZIMUTH), math.radians(ELEVATION)
        toward = numpy.array((math.sin(a) * math.cos(e), -math.cos(a) * math.cos(e), math.sin(e)))
        up = numpy.array((-math.sin(a) * math.sin(e), math.cos(a) * math.sin(e), math.cos(e)))
        middle = numpy.array([(n - 1) * s / 2 for n, s in zip(SIZE, SPACING)])
        camera = view.GetActiveCamera()
        camera.ParallelProjectionOn()
        camera.SetParallelScale(PIXELS * pixel_mm / 2)
        camera.SetFocalPoint(*middle)
        camera.SetPosition(*(middle + 500 * toward))
        camera.SetViewUp(*up)
        view.ResetCameraClippingRange()
        view.AutomaticLightCreationOff()
        lamp = vtk.vtkLight()
        lamp.SetLightTypeToSceneLight()
        right = numpy.cross(up, toward)
        lamp.SetPosition(*(middle + 5000 * (-0.40 * right + 0.55 * up + 0.80 * toward)))
        lamp.SetFocalPoint(*middle)
        lamp.SetAmbientColor(1, 1, 1)
        view.AddLight(lamp)
        window.Render()
        shot = vtk.vtkWindowToImageFilter()
        shot.SetInput(window)
        shot.ReadFrontBufferOff()
        shot.Update()
        return grey(numpy_support.vtk_to_numpy(shot.GetOutput().GetPointData().GetScalars()))

    def test_colors_and_opacities(self):
        ours, pixel_mm = self.draw("--mode", "volume", "--transfer", "t.json")
        theirs = self.vtk_picture(POINTS, pixel_mm, False)
        self.assertGreater(theirs.max(), 100)
        self.assertGreaterEqual(ssim(ours, theirs), LOWEST)

    def test_a_body_of_triangles_in_the_volume(self):
        # An opaque ball that the shell hides in part, in fog.
        ball = vtk.vtkSphereSource()
        ball.SetCenter(66, 30, 70)
        ball.SetRadius(17)
        ball.SetThetaResolution(60)
        ball.SetPhiResolution(60)
        writer = vtk.vtkSTLWriter()
        writer.SetInputConnection(ball.GetOutputPort())
        writer.SetFileName(str(self.folder / "ball.stl"))
        writer.SetFileTypeToBinary()
        writer.Write()
        mapper = vtk.vtkPolyDataMapper()
        mapper.SetInputConnection(ball.GetOutputPort())
        body = vtk.vtkActor()
        body.SetMapper(mapper)
        look = body.GetProperty()
        look.SetColor(220 / 255, 60 / 255, 50 / 255)
        look.SetAmbient(0.22)
        look.SetDiffuse(0.78)
        look.SetSpecular(0.16)
        look.SetSpecularPower(32)
        ours, pixel_mm = self.draw("--mode", "volume", "--transfer", "t.json", "--mesh",
                                   "ball.stl=#dc3c32")
        without, _ = self.draw("--mode", "volume", "--transfer", "t.json")
        theirs = self.vtk_picture(POINTS, pixel_mm, False, body)
        # Where it is seen it is a part of the picture, and where it is hidden it is not.
        seen = numpy.abs(ours - without) > 8
        self.assertGreater(seen.sum(), 1500)
        self.assertLess(numpy.median(numpy.abs(ours - theirs)[seen]), 8)
        self.assertGreaterEqual(ssim(ours, theirs), LOWEST)

    def test_the_highest_value(self):
        ours, pixel_mm = self.draw("--mode", "mip", "--window", "500,1000")
        ramp = [(0, (0, 0, 0), 1), (1000, (255, 255, 255), 1)]
        self.assertGreaterEqual(ssim(ours, self.vtk_picture(ramp, pixel_mm, True)), LOWEST)


if __name__ == "__main__":
    OCTAVO = os.path.abspath(sys.argv.pop(1))
    unittest.main()
