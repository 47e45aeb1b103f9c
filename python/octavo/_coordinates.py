"""Coordinates of arrays that xarray gets from octavo.xarray, and where arrays with them stand."""

import numpy as np

WORLD = "world LPS mm"
ALONG_AXES = "mm along the axes of the grid, from the first voxel of level 0"


def grid_coordinates(affine, translation):
    """(first, step) of the coordinates along z, y, x, and whether they are those of the world.

    They are where each axis is parallel to its own of the world; where it points the other way
    they descend.

    Parameters
    ----------
    affine : numpy.ndarray
        4 x 4: the index (z, y, x, 1) to the world, LPS x, y, z.
    translation : sequence of float
        Of the first voxel from that of level 0, along z, y, x.
    """
    own = np.linalg.norm(affine[:3, :3], axis=0)
    along = np.diag(affine[2::-1, :3])
    if np.allclose(np.abs(along), own, rtol=1e-6, atol=0):
        return list(zip(affine[2::-1, 3], np.copysign(own, along))), True
    return list(zip(translation, own)), False


def facts_of_coordinates(array):
    """The kind, spacing, origin and direction of an array of octavo.xarray, as far as it was
    sliced evenly; nothing of other arrays."""
    attributes = getattr(array, "attrs", None)
    if not isinstance(attributes, dict) or not {"kind", "affine", "translation"} <= {*attributes} \
            or getattr(array, "dims", None) != ("z", "y", "x"):
        return {}
    axes = [array.coords[axis] for axis in "zyx" if axis in array.coords]
    places = [_evenly(np.asarray(axis)) for axis in axes if axis.attrs.get("units") == "mm"]
    if len(places) < 3 or None in places:
        return {"kind": attributes["kind"]}
    affine = np.asarray(attributes["affine"], float).reshape(4, 4)
    of_level, _ = grid_coordinates(affine, np.asarray(attributes["translation"], float))
    # What a step of one voxel left out, where there is but one, is that of the level.
    firsts = [(first - start) / one for (first, _), (start, one) in zip(places, of_level)]
    steps = np.array([1 if step is None else step / one
                      for (_, step), (_, one) in zip(places, of_level)])
    own = np.linalg.norm(affine[:3, :3], axis=0)
    origin = affine[:3] @ [*firsts, 1]
    direction = affine[:3, :3] / own * np.sign(steps)
    return {"kind": attributes["kind"], "spacing": tuple(np.abs(steps) * own),
            "origin": tuple(origin[::-1]), "direction": direction[:, ::-1]}


def _evenly(places):
    """(first, step) of places, of one alone (first, None); None where steps differ."""
    if places.ndim != 1 or not len(places):
        return None
    steps = np.diff(places)
    if not len(steps):
        return places[0], None
    step = (places[-1] - places[0]) / len(steps)
    return (places[0], step) if step and np.allclose(steps, step, rtol=1e-6, atol=0) else None
