"""Slices, and what is seen from a side, as arrays of pixels."""

import os

import numpy as np

from . import _octavo
from ._errors import ArgumentError
from ._work import (AXES, asked_labels, if_given, level_of, number_of, range_of, several_of,
                    text_of, texts_of, three_of, whole_number, work_of)

_MOST_PICTURES = 999
_LOWEST = -(1 << 62)


class PictureTasks:
    """What is drawn of a volume or a label map."""

    def slice(self, axis="z", index=None, *, position_mm=None, plane=None, montage=None, every=None,
              level=0, window=None, preset="", labels=None, overlays=(), salvage=None, text=True,
              minimum_side=512, threads=0, max_memory=0, progress=None):
        """Draw a slice with square pixels.

        Parameters
        ----------
        axis : {"z", "y", "x"}
        index : int, optional
            In voxels of the level; the middle one by default.
        position_mm : float, optional
            In place of it: along the axis of the body, LPS.
        plane : (z, y, x) or ((z, y, x), (z, y, x)), optional
            In place of slices an oblique section: its normal, through the middle of the volume; or
            a point in mm (LPS) and the normal.
        montage : (int, int), optional
            So many columns and rows of slices in one picture.
        every : int, optional
            Of a montage: slices from one to the next.
        window : (low, high), optional
            Real values from black to white.
        preset : str
            In place of it one of the windows of CT: "bone", "lung", ...
        labels : int, str or several, optional
            Of label maps, also those over it, only these.
        overlays : Volume or LabelMap, or several
            Drawn over it, where they lie in space. In the place of one (overlay, dict): how it is
            drawn, by kind ("outline", "wash" or "isolines"), levels (real values), opacity and
            color.
        salvage : True, "coarse" or float, optional
            What damaged bricks are filled with, with a warning: True: their lowest value,
            "coarse": the next level that is whole, or a real value.
        text : bool
            Whether scale, sides, position and legend are written on it.
        minimum_side : int
            Smaller pictures are enlarged by a whole number.

        Returns
        -------
        numpy.ndarray of uint8, [y, x, 3]
        """
        if axis not in AXES:
            raise ArgumentError(f'axis is "z", "y" or "x", not {axis!r}')
        name, handle = self._opened_file()
        numbers, names = asked_labels(labels)
        point, normal = _plane(plane)
        filling, value = _salvage(salvage)
        asked = dict(axis=AXES[axis], index=if_given(whole_number, index, "index", _LOWEST),
                     level=level_of(level), preset=text_of(preset, "preset"),
                     position_mm=if_given(number_of, position_mm, "position_mm"),
                     point_mm=point, normal=normal,
                     montage=if_given(_two_counts, montage, "montage", "(columns, rows)"),
                     every=if_given(whole_number, every, "every", 1),
                     window=if_given(range_of, window, "a window"), text=bool(text),
                     labels=numbers, names=names, salvage=filling, salvage_value=value,
                     minimum_side=whole_number(minimum_side, "minimum_side", 0))
        drawn = _overlays(overlays, name)
        with work_of(threads, max_memory, progress) as work:
            return _octavo.slice(handle, name, drawn, asked, work)

    def render(self, mode=None, *, view="left-front-top", azimuth=None, elevation=None,
               direction=None, perspective=None, ranges=(), tissues=(), labels=None, level=None,
               isovalue=None, window=None, average=False, transfer=None, shade=None, fade=None,
               cuts=(), removed=(), mask=None, label_map=None, label_looks=None, meshes=(),
               marks=(), ambient_shade=False, shadows=False, smooth_edges=False, adaptive=False,
               moving=False, time_budget=None, size=(1024, 1024), zoom=1.0, turntable=0,
               grow=False, background="black", text=True, threads=0, max_memory=0, progress=None):
        """Draw what is seen from a side.

        Parameters
        ----------
        mode : {"cubes", "surface", "transparency", "volume", "mip", "minip", "mean", "iso"}
            "surface" for label maps, "volume" for grey values where it is not given. The last five
            follow rays.
        view : str
            "front", "left-top", ...; or azimuth and elevation in degrees; or direction: (z, y, x)
            toward the viewer, in voxels.
        perspective : float, optional
            Of rays: as an eye sees it, at so many degrees from top to bottom.
        ranges : sequence of (low, high) or (low, high, color) or (low, high, color, opacity)
            Of modes "cubes", "surface" and "transparency": real values to draw.
        tissues : sequence of str
            The same by name: "bone", ...
        labels : int, str or several, optional
            Of a label map only these.
        isovalue : float, optional
            Of mode "iso".
        window : (low, high), optional
            Of modes "mip", "minip" and "mean": real values; of mode "transparency": sums along
            lines of real values above the lowest of the ramp, times mm.
        average : bool
            Of mode "transparency": what is in front hides what is behind in part, in place of sums.
        transfer : str or os.PathLike, optional
            Of modes "volume" and "iso": a preset, or a file of JSON.
        shade : {"flat", "smooth"}, optional
            Of modes "cubes" and "surface".
        fade : float, optional
            How much darker the farthest is than the nearest, 0 to 1.
        cuts : str or several
            "x<120" keeps the voxels below index 120 along x, "z>40" those from there on.
        removed : sequence of ((z, y, x), (z, y, x))
            Boxes of voxels that are cut out, half-open; None for the end of the volume.
        mask : Volume or LabelMap, optional
            Of rays: they see no voxel where it is 0.
        label_map : Volume or LabelMap, optional
            Of modes "volume" and "iso": its labels are seen in their colors; `labels` chooses some.
        label_looks : dict, optional
            How labels of it look, by number or name, None for all others: a color, (color,
            opacity), a transfer function, "same": that of the picture, or None: not at all.
        meshes : sequence of path or (path, color) or (path, color, opacity)
            Of rays: surfaces of STL, PLY or OBJ files in the same picture.
        marks : sequence of (z, y, x) or ((z, y, x), text) or ((z, y, x), text, color)
            Of rays: balls at places in mm (LPS), with names.
        ambient_shade, shadows : bool
            Of modes "volume" and "iso": less light in hollows; shadows of what
            lies nearer to the lamp, voxels and meshes.
        smooth_edges, adaptive, moving : bool
            Of rays: four for a pixel at edges; one for 2 x 2 pixels that hardly differ; light of
            single cells, for pictures that move.
        time_budget : float, optional
            Of rays: the finest level that is drawn in so many seconds.
        size : (int, int)
            Width and height in pixels.
        turntable : int
            So many pictures once around the patient.
        grow : bool
            Of a turntable: picture i of N shows the first i / N of the planes along z.

        Returns
        -------
        numpy.ndarray of uint8, [y, x, 3]; of a turntable [picture, y, x, 3]
        """
        is_of_labels = getattr(self, "kind", "labels") == "labels"
        mode = mode or ("surface" if is_of_labels else "volume")
        name, handle = self._opened_file()
        numbers, names = asked_labels(labels)
        others, mask_name, map_name = _company(name, mask, label_map)
        asked = dict(
            mode=mode, view=text_of(view, "view"), azimuth=if_given(number_of, azimuth, "azimuth"),
            elevation=if_given(number_of, elevation, "elevation"),
            direction=if_given(three_of, direction, "direction"),
            perspective=if_given(number_of, perspective, "perspective"),
            ranges=[_range_look(r) for r in several_of(ranges, "ranges")],
            tissues=texts_of(tissues, "tissues"), labels=numbers, names=names,
            level=if_given(level_of, level), isovalue=if_given(number_of, isovalue, "isovalue"),
            window=if_given(range_of, window, "a window"), average=bool(average),
            transfer=if_given(_path_or_text, transfer, "transfer"),
            shade=shade, fade=if_given(_share, fade, "fade"),
            cuts=[_cut(c) for c in texts_of(cuts, "cuts")],
            removed=[_box(box) for box in several_of(removed, "removed")], mask=mask_name,
            label_map=map_name, label_looks=_label_looks(label_looks),
            meshes=[_mesh(one) for one in several_of(meshes, "meshes")],
            marks=[_mark(one) for one in several_of(marks, "marks")],
            ambient_shade=bool(ambient_shade), shadows=bool(shadows),
            smooth_edges=bool(smooth_edges), adaptive=bool(adaptive), moving=bool(moving),
            time_budget=if_given(number_of, time_budget, "time_budget"),
            size=_two_counts(size, "size", "(width, height)"), zoom=number_of(zoom, "zoom"),
            turntable=whole_number(turntable, "turntable", 0, _MOST_PICTURES), grow=bool(grow),
            background=text_of(background, "background"), text=bool(text))
        with work_of(threads, max_memory, progress) as work:
            pictures = _octavo.render(handle, name, others, asked, work)
        return np.stack(pictures) if turntable else pictures[-1]


def _two_counts(given, name, said):
    counts = several_of(given, said[1:-1].replace(",", " and"))
    if len(counts) != 2:
        raise ArgumentError(f"{name} is {said}, not {given!r}")
    return tuple(whole_number(count, f"a side of {name}", 0) for count in counts)


def _plane(given):
    """Point and normal, None where they are not given."""
    if given is None:
        return None, None
    parts = several_of(given, "plane")
    if len(parts) == 2:
        return three_of(parts[0], "the point of a plane"), three_of(parts[1], "a normal")
    return None, three_of(parts, "plane")


def _salvage(given):
    if given is None or given is False:
        return None, None
    if given is True:
        return "lowest", None
    if given == "coarse":
        return "coarse", None
    return "value", number_of(given, "salvage")


def _overlays(given, name):
    """(name, handle, look) of each, with names of their own."""
    from ._tasks import FileTasks, opened_file
    if isinstance(given, FileTasks):
        given = (given,)
    drawn = []
    for number, one in enumerate(several_of(given, "overlays")):
        overlay, look = one if isinstance(one, tuple) and len(one) == 2 else (one, {})
        its_name, handle = opened_file(overlay, "an overlay")
        if its_name in (name, *(n for n, _, _ in drawn)):
            its_name += f" ({number + 2})"
        drawn.append((its_name, handle, _overlay_look(look)))
    return drawn


def _overlay_look(look):
    if not isinstance(look, dict) or set(look) - {"kind", "levels", "opacity", "color"}:
        raise ArgumentError(f"how an overlay is drawn is a dict of kind, levels, opacity and "
                            f"color, not {look!r}")
    return dict(kind=look.get("kind"),
                levels=[number_of(v, "a level") for v in several_of(look.get("levels", ()),
                                                                    "levels")],
                opacity=if_given(_share, look.get("opacity"), "opacity"),
                color=if_given(text_of, look.get("color"), "color"))


def _company(name, mask, label_map):
    """(name, handle) of the volumes beside it, and the names of both."""
    from ._tasks import opened_beside
    others, names = [], []
    for given, what in ((mask, "mask"), (label_map, "label_map")):
        if given is not None:
            others.append(opened_beside(given, what, name, *names))
        names.append("" if given is None else others[-1][0])
    return others, *names


def _range_look(given):
    low, high, color, opacity = _filled(given, 2, 4, "a range", "(low, high, color, opacity)")
    return (*range_of((low, high)), if_given(text_of, color, "a color"),
            if_given(_share, opacity, "opacity"))


def _filled(given, fewest, most, name, said):
    """The parts of `given`, with None for those that may be left out and are."""
    parts = several_of(given, name)
    if not fewest <= len(parts) <= most:
        raise ArgumentError(f"{name} is {said}, not {given!r}")
    return parts + [None] * (most - len(parts))


def _share(given, name):
    share = number_of(given, name)
    if not 0 <= share <= 1:
        raise ArgumentError(f"{name} is from 0 to 1, not {given!r}")
    return share


def _path_or_text(given, name):
    return text_of(os.fspath(given) if isinstance(given, os.PathLike) else given, name)


def _cut(given):
    axis, side, index = given[:1], given[1:2], given[2:]
    if axis not in AXES or side not in ("<", ">") or not index.strip().lstrip("-").isdigit():
        raise ArgumentError(f'a cut is like "x<120" or "z>40", not {given!r}')
    return AXES[axis], side == "<", whole_number(int(index), "the index of a cut", _LOWEST)


def _box(given):
    ends = several_of(given, "a box")
    if len(ends) != 2 or any(len(several_of(end, "an end of a box")) != 3 for end in ends):
        raise ArgumentError(f"a box is ((z, y, x), (z, y, x)), not {given!r}")
    return tuple([if_given(whole_number, n, "an end of a box", _LOWEST) for n in end]
                 for end in ends)


def _label_looks(given):
    if given is not None and not isinstance(given, dict):
        raise ArgumentError(f"label_looks is a dict, label: look, not {given!r}")
    looks = []
    for label, look in (given or {}).items():
        numbers, names = asked_labels(label)
        opacity = None
        if isinstance(look, tuple):
            look, opacity = _filled(look, 2, 2, "a look", "(color, opacity)")
            opacity = _share(opacity, "opacity")
        looks.append(dict(labels=numbers, names=names, opacity=opacity,
                          look=if_given(_path_or_text, look, "a look")))
    return looks


def _mesh(given):
    parts = [given] if isinstance(given, (str, os.PathLike)) else given
    path, color, opacity = _filled(parts, 1, 3, "a mesh", "(path, color, opacity)")
    return (_path_or_text(path, "the path of a mesh"), if_given(text_of, color, "a color"),
            1.0 if opacity is None else _share(opacity, "opacity"))


def _mark(given):
    parts = several_of(given, "a mark")
    if len(parts) == 3 and not isinstance(parts[1], str):
        parts = [parts]
    place, text, color = _filled(parts, 1, 3, "a mark", "((z, y, x), text, color)")
    return (three_of(place, "the place of a mark"), text_of(text or "", "the text of a mark"),
            if_given(text_of, color, "a color"))
