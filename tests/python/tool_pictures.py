"""Pictures of a scan in other tools, as docs/python-tools.md shows them; the tools draw them.

usage: tests/python/tool_pictures.py SCAN.8vo FOLDER    on a display, as of xvfb-run
"""

import pathlib
import sys

import numpy as np

import octavo
from octavo._notebook import png_of


def napari_picture(volume, mask, path):
    """The window of napari: a slice of the image, and the mask as labels over it."""
    import napari
    from octavo.napari import layer_of
    viewer = napari.Viewer(show=True)
    viewer.window.resize(1000, 700)
    for one in (volume, mask):
        levels, attributes, kind = layer_of(one)
        getattr(viewer, f"add_{kind}")(levels, **attributes)
    viewer.layers[1].opacity = 0.4
    viewer.dims.set_point(0, viewer.dims.range[0].stop / 2)
    viewer.reset_view()
    for _ in range(50):
        viewer.window._qt_window.repaint()
        napari.qt.get_qapp().processEvents()
    viewer.screenshot(str(path), canvas_only=False, flash=False)
    viewer.close()


def vtk_picture(volume, path):
    """A surface that VTK's own filter makes of what the reader gives."""
    from octavo.vtk import Reader
    from vtkmodules import vtkInteractionStyle, vtkRenderingOpenGL2  # noqa: F401
    from vtkmodules.vtkFiltersCore import vtkFlyingEdges3D, vtkPolyDataConnectivityFilter
    from vtkmodules.vtkIOImage import vtkPNGWriter
    from vtkmodules.vtkRenderingCore import (vtkActor, vtkPolyDataMapper, vtkRenderer,
                                             vtkRenderWindow, vtkWindowToImageFilter)
    reader = Reader(volume.name, level=1)
    surface = vtkFlyingEdges3D()
    surface.SetInputConnection(reader.GetOutputPort())
    surface.SetValue(0, 226)
    largest = vtkPolyDataConnectivityFilter()
    largest.SetInputConnection(surface.GetOutputPort())
    largest.SetExtractionModeToLargestRegion()
    mapper = vtkPolyDataMapper()
    mapper.SetInputConnection(largest.GetOutputPort())
    mapper.ScalarVisibilityOff()
    actor = vtkActor()
    actor.SetMapper(mapper)
    actor.GetProperty().SetColor(0.91, 0.85, 0.69)
    scene = vtkRenderer()
    scene.AddActor(actor)
    window = vtkRenderWindow()
    window.SetOffScreenRendering(1)
    window.SetSize(560, 560)
    window.AddRenderer(scene)
    camera = scene.GetActiveCamera()
    camera.SetPosition(1, 2, 0.5)
    camera.SetFocalPoint(0, 0, 0)
    camera.SetViewUp(0, 0, 1)
    scene.ResetCamera()
    camera.Zoom(1.2)
    window.Render()
    shot = vtkWindowToImageFilter()
    shot.SetInput(window)
    writer = vtkPNGWriter()
    writer.SetFileName(str(path))
    writer.SetInputConnection(shot.GetOutputPort())
    writer.Write()


def plotted(path, draw, width=5.6, height=4.2):
    """What `draw` puts into axes of matplotlib."""
    import matplotlib
    matplotlib.use("Agg")
    from matplotlib import pyplot
    figure, axes = pyplot.subplots(figsize=(width, height), layout="constrained")
    draw(axes)
    figure.savefig(path, dpi=100)
    pyplot.close(figure)


def xarray_picture(volume, path):
    """A slice at a place in mm, drawn by xarray with its coordinates."""
    import xarray
    from octavo.xarray import OctavoBackend
    voxels = xarray.open_dataset(volume.name, engine=OctavoBackend)["voxels"]
    z = float(voxels.z[len(voxels.z) // 2])

    def draw(axes):
        voxels.sel(z=z, method="nearest").plot(ax=axes, cmap="gray", yincrease=False, vmin=-200,
                                               vmax=800)
        axes.set_aspect("equal")

    plotted(path, draw)


def dask_picture(volume, path):
    """A histogram of all voxels of a level, counted chunk by chunk."""
    import dask.array
    real = octavo.as_dask(volume.real, level=1)
    counts, edges = dask.array.histogram(real, bins=120, range=(-1000, 2000))

    def draw(axes):
        axes.stairs(counts.compute(), edges, fill=True, color="0.4")
        axes.set_yscale("log")
        axes.set_xlabel(f"value, {volume.unit or 'no unit'}")
        axes.set_ylabel(f"voxels of level 1, in {real.npartitions} chunks")
    plotted(path, draw)


def sitk_picture(volume, path):
    """Edges that a filter of SimpleITK finds in a level, where they lie in the body."""
    import SimpleITK
    from octavo.sitk import to_sitk
    image = to_sitk(volume.levels[1], real=True)
    edges = SimpleITK.GradientMagnitudeRecursiveGaussian(image, sigma=1.5)
    plane = SimpleITK.GetArrayViewFromImage(edges)[edges.GetDepth() // 2]
    ends = [edges.TransformIndexToPhysicalPoint(index) for index in
            ((0, 0, 0), (edges.GetWidth() - 1, edges.GetHeight() - 1, 0))]

    def draw(axes):
        axes.imshow(plane, cmap="magma", extent=(ends[0][0], ends[1][0], ends[1][1], ends[0][1]))
        axes.set_xlabel("x, mm, LPS")
        axes.set_ylabel("y, mm, LPS")
    plotted(path, draw, 4.6, 4.6)


def torch_picture(volume, mask, path):
    """A batch of patches, as a network gets them."""
    try:
        from octavo.torch import PatchDataset
    except ImportError:
        return
    planes = []
    for image, labels in PatchDataset([(volume.name, mask.name)], (32, 96, 96), 6, seed=4):
        plane = np.clip((image[0, 16].numpy() + 200) / 1000, 0, 1)
        colors = np.where(labels[0, 16, :, :, None] > 0, (1, 0.6, 0.3), (1, 1, 1))
        planes.append(np.pad(plane[..., None] * colors, ((0, 2), (0, 2), (0, 0))))
    sheet = np.vstack([np.hstack(planes[:3]), np.hstack(planes[3:])])
    pixels = (255 * sheet).astype(np.uint8).repeat(2, 0).repeat(2, 1)
    path.write_bytes(png_of(np.ascontiguousarray(pixels)))


def main():
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    folder = pathlib.Path(sys.argv[2])
    folder.mkdir(parents=True, exist_ok=True)
    volume = octavo.open(sys.argv[1])
    largest = volume.threshold(226).components(keep_largest=1)
    mask = largest.saved()
    torch_picture(volume, mask, folder / "torch.png")
    if not _has("napari"):
        return
    xarray_picture(volume, folder / "xarray.png")
    dask_picture(volume, folder / "dask.png")
    sitk_picture(volume, folder / "simpleitk.png")
    vtk_picture(volume, folder / "vtk.png")
    napari_picture(volume, mask, folder / "napari.png")
    for path in folder.glob("*.png"):
        if _spread(path) < 10:
            sys.exit(f"{path} shows nothing")


def _spread(path):
    from PIL import Image
    return np.asarray(Image.open(path).convert("L")).std()


def _has(name):
    import importlib.util
    return importlib.util.find_spec(name) is not None


if __name__ == "__main__":
    main()
