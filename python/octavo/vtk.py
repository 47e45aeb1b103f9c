"""A reader for VTK and ParaView that decodes what a pipeline asks for.

    reader = octavo.vtk.Reader("scan.8vo", level=1)
    reader.UpdateExtent((0, 63, 0, 63, 10, 10))
    reader.GetOutputDataObject(0)
"""

import numpy as np
from vtkmodules.util import numpy_support
from vtkmodules.util.vtkAlgorithm import VTKPythonAlgorithmBase
from vtkmodules.vtkCommonDataModel import vtkImageData
from vtkmodules.vtkCommonExecutionModel import vtkAlgorithm, vtkStreamingDemandDrivenPipeline

from ._volume import Volume


class Reader(VTKPythonAlgorithmBase):
    """A level of a file as vtkImageData, with its place in the world (LPS, mm).

    Only the bricks that UPDATE_EXTENT meets are decoded.

    Parameters
    ----------
    path : str, os.PathLike or bytes
        As of `octavo.open`.
    level : int
    real : bool
        Real values of grey volumes as float32; stored ones otherwise. Labels stay as they are.
    """

    def __init__(self, path, level=0, real=True):
        super().__init__(nInputPorts=0, nOutputPorts=1, outputType="vtkImageData")
        self._volume = Volume(path)
        self._level = level
        self._real = real

    @property
    def volume(self):
        """The file that is read."""
        return self._volume

    def SetLevel(self, level):
        """Reads another level from the next update on."""
        self._level = level
        self.Modified()

    def RequestInformation(self, _request, _inputs, outputs):
        """Extent, spacing, origin and direction, without reading voxels."""
        view = self._view()
        depth, height, width = view.shape
        info = outputs.GetInformationObject(0)
        info.Set(vtkStreamingDemandDrivenPipeline.WHOLE_EXTENT(),
                 (0, width - 1, 0, height - 1, 0, depth - 1), 6)
        info.Set(vtkImageData.SPACING(), view.spacing[::-1], 3)
        info.Set(vtkImageData.ORIGIN(), view.origin[::-1], 3)
        info.Set(vtkImageData.DIRECTION(), self._direction(), 9)
        info.Set(vtkAlgorithm.CAN_PRODUCE_SUB_EXTENT(), 1)
        return 1

    def RequestData(self, _request, _inputs, outputs):
        """The voxels of the extent that is asked for."""
        view = self._view()
        info = outputs.GetInformationObject(0)
        x0, x1, y0, y1, z0, z1 = info.Get(vtkStreamingDemandDrivenPipeline.UPDATE_EXTENT())
        voxels = view[z0:z1 + 1, y0:y1 + 1, x0:x1 + 1]
        image = vtkImageData.GetData(outputs, 0)
        image.SetExtent(x0, x1, y0, y1, z0, z1)
        image.SetSpacing(view.spacing[::-1])
        image.SetOrigin(view.origin[::-1])
        image.SetDirectionMatrix(self._direction())
        array = numpy_support.numpy_to_vtk(np.ascontiguousarray(voxels).ravel(), deep=True)
        array.SetName("labels" if self._volume.kind == "labels" else "values")
        image.GetPointData().SetScalars(array)
        return 1

    def _view(self):
        is_real = self._real and self._volume.kind == "grey"
        return (self._volume.real.levels if is_real else self._volume.levels)[self._level]

    def _direction(self):
        """Row-major, columns x, y, z."""
        return tuple(float(n) for n in self._volume._file.facts["direction"])
