"""What notebooks show of a volume: its middle slice and its facts; a small viewer."""

import base64
import html

from . import _octavo
from ._errors import ArgumentError, Error, package_error

# Voxels of a slice that is drawn without being asked for.
_MOST_DRAWN = 1 << 20


def png_of(pixels):
    """The bytes of a PNG picture of an array of pixels [y, x, 3], uint8."""
    return _octavo.png(pixels)


def html_of(volume):
    """The middle slice beside a table of facts; facts alone of what cannot be read."""
    level = next((view for view in volume.levels
                  if view.shape[1] * view.shape[2] <= _MOST_DRAWN), volume.levels[-1])
    rows = "".join(f"<tr><th style='text-align:left'>{name}</th>"
                   f"<td style='text-align:left'>{html.escape(str(value))}</td></tr>"
                   for name, value in _facts_of(volume))
    table = f"<table>{rows}</table>"
    try:
        picture = volume.slice(level=level.level, minimum_side=128)
    except Error:
        return table
    data = base64.b64encode(png_of(picture)).decode()
    return (f"<div style='display:flex;gap:1em;align-items:center'>"
            f"<img style='max-width:256px;max-height:256px' src='data:image/png;base64,{data}'>"
            f"{table}</div>")


def viewer(volume, axis="z", level=None, **look):
    """A slider over the slices of a volume, for notebooks.

    Parameters
    ----------
    volume : Volume or LabelMap
    axis : {"z", "y", "x"}
    level : int, optional
        The finest one whose slices have about a million voxels, where it is not given.
    **look
        Of `Volume.slice`: window, overlays, ...

    Returns
    -------
    ipywidgets.VBox

    Raises
    ------
    octavo.ArgumentError
        Where ipywidgets is not installed.
    """
    try:
        import ipywidgets
    except ImportError as error:
        raise package_error("ipywidgets", "a viewer needs ipywidgets (pip install ipywidgets)",
                            error) from None
    if level is None:
        views = getattr(volume, "levels", (volume,))
        level = next((number for number, view in enumerate(views)
                      if view.size / max(1, min(view.shape)) <= _MOST_DRAWN), len(views) - 1)
    view = volume.levels[level] if hasattr(volume, "levels") else volume
    count = view.shape["zyx".index(axis)]
    picture = ipywidgets.Image(format="png")
    slider = ipywidgets.IntSlider(value=count // 2, min=0, max=count - 1, description=axis,
                                  continuous_update=False)

    def draw(change):
        picture.value = png_of(volume.slice(axis, change["new"], level=level, **look))

    slider.observe(draw, names="value")
    draw({"new": slider.value})
    return ipywidgets.VBox([slider, picture])


def _facts_of(volume):
    unit = {"[hnsf'U]": "HU"}.get(volume.unit, volume.unit)
    low, high = sorted((volume.slope * volume.min + volume.intercept,
                        volume.slope * volume.max + volume.intercept))
    yield "file", volume.name
    yield "voxels", f"{' x '.join(map(str, volume.shape))} (z, y, x), {volume.dtype}"
    if volume.is_spacing_known:
        yield "spacing", f"{' x '.join(f'{s:.4g}' for s in volume.spacing)} mm"
    else:
        yield "spacing", "not known"
    if volume.kind == "labels":
        names = len(volume.label_names)
        yield "labels", f"{names} with names" if names else "no names"
    else:
        yield "values", f"{low:g} to {high:g}{f' {unit}' if unit else ''}"
    yield "loss", "none" if volume.max_error == 0 else f"at most {volume.max_error:g} (stored)"
    yield "levels", len(volume.levels)
    yield "bytes", f"{volume.file_bytes:,}, {volume.nbytes / volume.file_bytes:.2f} : 1"
