"""Surfaces of triangles, and meshes of hexahedra."""

from typing import NamedTuple

import numpy as np

from . import _octavo
from ._errors import ArgumentError
from ._sources import if_written, written_path
from ._work import (asked_labels, if_given, level_of, number_of, several_of, three_of,
                    whole_number, work_of)

_MOST_STEPS = 1000


class Surface(NamedTuple):
    """A closed surface of triangles.

    Attributes
    ----------
    vertices : numpy.ndarray of float32, (n, 3)
        x, y, z in mm, LPS or RAS as asked for.
    faces : numpy.ndarray of uint32, (m, 3)
        Vertices of each triangle, counterclockwise seen from outside.
    facts : dict
        closed, manifold, components, area_mm2, volume_mm3, max_deviation_mm, full_triangles,
        crossing_triangles.
    """

    vertices: np.ndarray
    faces: np.ndarray
    facts: dict


class SurfaceTasks:
    """Meshes of a volume or a label map."""

    def surface(self, isovalue=None, *, labels=None, stored=False, level=0, seed=None,
                max_deviation_mm=0.0, max_deviation_voxels=None, triangles=None, method="collapse",
                space="lps", threads=0, max_memory=0, progress=None):
        """The surface of what lies inside, closed and turned outward.

        Parameters
        ----------
        isovalue : float, optional
            Of grey values, in real units: what is at or above it lies inside.
        labels : int, str or several, optional
            Of a label map these; without any every voxel but 0.
        stored : bool
            The isovalue is a stored value.
        level : int
        seed : (z, y, x), optional
            Only the piece that comes nearest to this place, in voxels of the level.
        max_deviation_mm : float
            Fewer triangles, proven to lie so near to the full surface, and that to them.
        max_deviation_voxels : float, optional
            The same, of the shortest side of a voxel.
        triangles : int or str, optional
            Instead: so many at most, or "5%" of all.
        method : {"collapse", "octree"}
            How triangles become fewer: edges collapse, or cells merge.
        space : {"lps", "ras"}

        Returns
        -------
        Surface
            (vertices, faces, facts)

        Raises
        ------
        octavo.ArgumentError
            Where nothing lies inside.
        """
        name, handle = self._opened_file()
        asked = _asked(isovalue, labels, stored, level, seed, space, method, True,
                       _fewer(max_deviation_mm, max_deviation_voxels, triangles))
        with work_of(threads, max_memory, progress) as work:
            return Surface(*_octavo.surface(handle, name, asked, work))

    def save_surface(self, path, isovalue=None, *, labels=None, stored=False, level=0, seed=None,
                     max_deviation_mm=0.0, max_deviation_voxels=None, triangles=None,
                     method="collapse", space="lps", plain=False, report=None, allow_faults=False,
                     overwrite=False, threads=0, max_memory=0, progress=None):
        """Write the surface to a file that ends in .stl, .ply, .obj, .glb, .vtp or .3mf.

        As `surface`; nothing is written where the surface is not closed or not manifold, unless
        `allow_faults`. `plain` leaves compression out of a .glb file; `report` is a file of JSON
        for what is known of the surface.

        Returns
        -------
        dict
            The facts of `Surface`, and points, triangles, file_bytes.
        """
        name, handle = self._opened_file()
        path = written_path(path)
        asked = _asked(isovalue, labels, stored, level, seed, space, method, allow_faults,
                       _fewer(max_deviation_mm, max_deviation_voxels, triangles))
        asked.update(plain=bool(plain), report=if_written(report))
        with work_of(threads, max_memory, progress) as work:
            return _octavo.save_surface(handle, name, path, bool(overwrite), asked, work)

    def save_label_surfaces(self, path, *, form="parts", part_format="stl", labels=None, level=0,
                            smooth=20, max_deviation_mm=0.0, max_deviation_voxels=None,
                            triangles=None, space="lps", overwrite=False, threads=0, max_memory=0,
                            progress=None):
        """Write the surfaces between the labels of a label map, which fit each other.

        Parameters
        ----------
        path : str or os.PathLike
            Of parts a file of a format that knows parts, all but .stl, or else a folder; of
            interfaces a .ply, .obj or .vtp file.
        form : {"parts", "interfaces"}
            A closed surface for each label, or all surfaces once, with the labels on both sides.
        part_format : {"stl", "ply", "obj", "glb", "vtp", "3mf"}
            Of the files in a folder.
        labels : int, str or several, optional
        smooth : int
            Steps of smoothing; 0: the sides of voxels.
        max_deviation_mm, max_deviation_voxels, triangles, space
            As of `surface`.

        Returns
        -------
        dict
            points, triangles, full_triangles, max_deviation_mm, crossing_triangles, pairs,
            file_bytes, and labels: a dict for each, of label, path, points, triangles, closed,
            manifold, components, touching_points, area_mm2, volume_mm3, voxels, volume_change,
            longest_move_mm.

        Raises
        ------
        octavo.ArgumentError
            For grey values, and for formats that cannot hold what is asked for.
        """
        name, handle = self._opened_file()
        asked = _asked_labels(labels, level, space)
        asked.update(_fewer(max_deviation_mm, max_deviation_voxels, triangles),
                     form=form, part_format=part_format,
                     smooth=whole_number(smooth, "smooth", 0, _MOST_STEPS))
        path = written_path(path)
        with work_of(threads, max_memory, progress) as work:
            return _octavo.save_label_surfaces(handle, name, path, bool(overwrite), asked, work)

    def save_hexahedra(self, path, *, method="uniform", labels=None, level=0, keep_largest=False,
                       of=None, density=None, modulus=None, min_modulus=1.0, poisson_ratio=0.3,
                       bins=32, quality=False, overwrite=False, threads=0, max_memory=0,
                       progress=None):
        """Write a mesh of hexahedra for solvers: .vtu, .inp, .msh or .mesh.

        Parameters
        ----------
        method : {"uniform", "octree", "conforming"}
            Every voxel an element; the leaves of the octree, at which nodes hang; or leaves with
            pyramids and tetrahedra between.
        labels : int, str or several, optional
        keep_largest : bool
            Only the largest part that is connected over faces.
        of : Volume, optional
            The scan on the same grid, for materials.
        density : (slope, intercept), optional
            g/cm3 of a grey value: slope * value + intercept.
        modulus : (factor, exponent), optional
            MPa of a density: factor * density ** exponent, never below `min_modulus`.
        bins : int
            Materials that each label has at most.
        quality : bool
            Whether scaled Jacobians and volumes of the elements are measured.

        Returns
        -------
        dict
            elements, elements_of_shape, nodes, hanging_nodes, parts, voxels, cells_of_level,
            labels, materials, modulus_range_mpa, volume_mm3, quality, file_bytes.
        """
        from ._tasks import opened_beside
        name, handle = self._opened_file()
        others = [] if of is None else [opened_beside(of, "of", name)]
        numbers, names = asked_labels(labels)
        asked = dict(method=method, labels=numbers, names=names,
                     level=level_of(level), keep_largest=bool(keep_largest),
                     density=if_given(_two, density, "density", "(slope, intercept)"),
                     modulus=if_given(_two, modulus, "modulus", "(factor, exponent)"),
                     min_modulus=number_of(min_modulus, "min_modulus"),
                     poisson_ratio=number_of(poisson_ratio, "poisson_ratio"),
                     bins=whole_number(bins, "bins", 1, 100_000), quality=bool(quality),
                     overwrite=bool(overwrite))
        path = written_path(path)
        with work_of(threads, max_memory, progress) as work:
            return _octavo.save_hexahedra(handle, name, path, others, asked, work)


def _fewer(mm, voxels, triangles):
    """How many triangles are left, as the extension takes it."""
    mm = number_of(mm, "max_deviation_mm")
    if voxels is not None and mm:
        raise ArgumentError("give max_deviation_mm or max_deviation_voxels, not both")
    deviation = (mm, False) if voxels is None else (number_of(voxels, "max_deviation_voxels"), True)
    return dict(max_deviation=deviation, triangles=if_given(_triangles, triangles))


def _triangles(given):
    if isinstance(given, str) and given.endswith("%"):
        return number_of(given[:-1], "triangles"), True
    if isinstance(given, str):
        raise ArgumentError(f'triangles is a number or like "5%", not {given!r}')
    return number_of(given, "triangles"), False


def _asked_labels(labels, level, space):
    numbers, names = asked_labels(labels)
    return dict(labels=numbers, names=names, level=level_of(level),
                space=space)


def _asked(isovalue, labels, stored, level, seed, space, method, allow_faults, fewer):
    return dict(_asked_labels(labels, level, space), **fewer,
                isovalue=if_given(number_of, isovalue, "isovalue"), stored=bool(stored),
                seed=if_given(three_of, seed, "seed"), method=method,
                allow_faults=bool(allow_faults))


def _two(given, name, said):
    numbers = several_of(given, name)
    if len(numbers) != 2:
        raise ArgumentError(f"{name} is {said}, not {given!r}")
    return tuple(number_of(n, name) for n in numbers)
