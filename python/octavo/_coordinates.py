"""Where arrays stand that xarray gets from octavo.xarray, read from their coordinates."""

import numpy as np


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
    affine = np.asarray(attributes["affine"], float)
    # What a step of one voxel left out, where there is but one, is that of the level.
    own = np.linalg.norm(affine[:3, :3], axis=0)
    firsts = np.array([first for first, _ in places])
    steps = np.array([usual if step is None else step for (_, step), usual in zip(places, own)])
    unit = affine[:3, :3] / own
    start = affine[:3, 3]
    known = start[::-1] if _is_upright(unit) else np.asarray(attributes["translation"], float)
    origin = start + unit @ (firsts - known)
    direction = unit * np.sign(steps)
    return {"kind": attributes["kind"], "spacing": tuple(np.abs(steps)),
            "origin": tuple(origin[::-1]), "direction": direction[:, ::-1]}


def _is_upright(unit):
    return np.allclose(unit, np.eye(3)[:, ::-1], atol=1e-6)


def _evenly(places):
    """(first, step) of places, of one alone (first, None); None where steps differ."""
    if places.ndim != 1 or not len(places):
        return None
    steps = np.diff(places)
    if not len(steps):
        return places[0], None
    step = (places[-1] - places[0]) / len(steps)
    return (places[0], step) if step and np.allclose(steps, step, rtol=1e-6, atol=0) else None
