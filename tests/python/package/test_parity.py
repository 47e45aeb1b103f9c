"""Every option of the program's verbs, and where Python has it."""

import inspect
import operator
import re

import pytest

import octavo

SHELL = "of the shell"      # what a result is printed or written as
PROGRAM = "of the program"  # Python leaves it to the program
WORK = {"quiet": SHELL, "verbose": SHELL, "json": SHELL, "strict": "warnings", "help": SHELL,
        "progress": "progress", "threads": "threads", "max-memory": "max_memory",
        "max-voxels": PROGRAM, "timeout": "of fsspec", "force": "overwrite"}
LABEL, OUTPUT = {"label": "labels"}, {"output": SHELL}
PARTS = {"part": PROGRAM, "join": PROGRAM}
MORPH = {**OUTPUT, "connectivity": "connectivity"}

# verb: (method, {option: parameter, or why there is none})
VERBS = {
    "align": ("LabelMap.align", {"output": "output", "picture": "picture", "scale": "scale"}),
    "close": ("LabelMap.close", MORPH),
    "compare": ("Volume.compare", {"max-error": "max_error"}),
    "components": ("LabelMap.components", {
        **OUTPUT, **PARTS, "numbers": PROGRAM, "connectivity": "connectivity",
        "keep-largest": "keep_largest", "min-mm3": "min_mm3", "rows": SHELL}),
    "condense": ("Volume.condense", {
        "output": "path", "flat": "flat", "self-similar": "Volume.self_similarity.max_difference",
        "up-to-mean": "Volume.self_similarity.up_to_mean",
        "coded": "Volume.self_similarity.coded"}),
    "dilate": ("LabelMap.dilate", MORPH),
    "distance": ("LabelMap.distance", {"output": "path", "to": "to", "max-mm": "max_mm",
                                       "step": "step_mm", "steps": "step_mm",
                                       "within": "within_mm"}),
    "erode": ("LabelMap.erode", MORPH),
    "fill-holes": ("LabelMap.fill_holes", {**OUTPUT, "connectivity": "connectivity",
                                           "max-mm3": "max_mm3"}),
    "hexahedra": ("LabelMap.save_hexahedra", {
        **LABEL, "output": "path", "uniform": "method", "octree": "method", "conforming": "method",
        "level": "level", "keep-largest": "keep_largest", "of": "of", "density": "density",
        "modulus": "modulus", "min-modulus": "min_modulus", "poisson": "poisson_ratio",
        "bins": "bins", "quality": "quality"}),
    "measure": ("LabelMap.measure", {**OUTPUT, **LABEL, **PARTS, "of": "of", "csv": SHELL,
                                     "percentile": "percentiles",
                                     "no-percentiles": "percentiles"}),
    "morphometry": ("LabelMap.morphometry", {
        "region": "region", "of": "of", "calibration": "calibration", "histogram": "histogram",
        "thickness-map": "thickness_map", "spacing-map": "spacing_map", "tortuosity": "tortuosity",
        "diffusion": "diffusion",
        "no-thickness": "thickness", "slices": SHELL, "csv": SHELL}),
    "open": ("LabelMap.open", MORPH),
    "render": ("Volume.render", {
        **OUTPUT, **LABEL, "mode": "mode", "shade": "shade", "range": "ranges",
        "tissue": "tissues", "level": "level", "transfer": "transfer", "isovalue": "isovalue",
        "perspective": "perspective", "mesh": "meshes", "mark": "marks", "mask": "mask",
        "labels": "label_map", "label-look": "label_looks", "ambient-shade": "ambient_shade",
        "shadows": "shadows", "time-budget": "time_budget", "progressive": SHELL,
        "adaptive": "adaptive", "moving": "moving", "smooth-edges": "smooth_edges",
        "cut": "cuts", "average": "average", "window": "window", "size": "size",
        "direction": "view", "azimuth": "azimuth", "elevation": "elevation", "zoom": "zoom",
        "turntable": "turntable", "grow": "grow", "fps": SHELL, "background": "background",
        "fade": "fade", "no-scale-bar": "text", "no-sides": "text", "no-legend": "text"}),
    "shell": ("LabelMap.shell", OUTPUT),
    "slice": ("Volume.slice", {
        **OUTPUT, **LABEL, "axis": "axis", "index": "index", "mm": "position_mm",
        "montage": "montage", "every": "every", "plane": "plane", "level": "level",
        "window": "window", "size": "minimum_side", "overlay": "overlays",
        "overlay-as": "overlays", "overlay-levels": "overlays", "overlay-color": "overlays",
        "overlay-opacity": "overlays", "no-scale-bar": "text", "no-sides": "text",
        "no-notes": "text", "no-legend": "text", "salvage": "salvage"}),
    "surface": ("Volume.save_surface", {
        **LABEL, "output": "path", "isovalue": "isovalue", "level": "level", "seed": "seed",
        "max-deviation": "max_deviation_mm", "triangles": "triangles", "method": "method",
        "report": "report", "space": "space", "stored": "stored", "plain": "plain",
        "allow-open": "allow_faults", "parts": "Volume.save_label_surfaces.form",
        "interfaces": "Volume.save_label_surfaces.form",
        "part-format": "Volume.save_label_surfaces.part_format",
        "smooth": "Volume.save_label_surfaces.smooth"}),
    "threshold": ("Volume.threshold", {
        **OUTPUT, "range": "ranges", "tissue": "tissue", "label": "Volume.mask.labels",
        "class": "Volume.classify.classes", "stored": "stored"}),
    "touch": ("LabelMap.touch", {"connectivity": "connectivity"}),
    "transform": ("Volume.transform", {
        "output": "path", "grid-of": "grid_of", "inverse": "inverse", "in-place": "in_place",
        "interpolation": "interpolation", "fill": "fill", "preset": "preset",
        "max-error": "max_error", "translate": "steps", "translate-mm": "steps", "shift": "steps",
        "rotate": "steps", "mirror": "steps", "scale": "steps", "affine": "steps"}),
}
# The other verbs: what of the package does their work, or why nothing does.
OTHERWISE = {
    "build": "build", "combine": "LabelMap.__and__", "info": "Volume.attrs",
    "probe": "Volume.read", "export": "export", "extract": "export",
    "codes": "LabelMap.counts", "verify": PROGRAM, "repair": PROGRAM, "plan": PROGRAM,
    "part": PROGRAM, "join": PROGRAM, "serve": PROGRAM, "view": PROGRAM, "publish": PROGRAM,
    "phantom": PROGRAM, "completion": SHELL, "manual": SHELL,
}
NONE_IN_PYTHON = {SHELL, PROGRAM, "warnings", "of fsspec"}


def parameters_of(place):
    return set(inspect.signature(operator.attrgetter(place)(octavo)).parameters)


def test_every_verb_stands_in_a_table(run):
    listed = run("--help").stdout.split("\nVerbs:\n")[1].split("\n\n")[0]
    offered = re.findall(r"^  ([a-z][a-z-]*)", listed, re.MULTILINE)
    assert "threshold" in offered and "completion" in offered
    for place in {*OTHERWISE.values()} - NONE_IN_PYTHON:
        operator.attrgetter(place)(octavo)
    assert sorted(offered) == sorted([*VERBS, *OTHERWISE])


@pytest.mark.parametrize("verb", VERBS)
def test_python_has_what_the_program_offers(run, verb):
    method, options = VERBS[verb]
    said = run(verb, "--help").stdout
    offered = set(re.findall(r"^  (?:-\w,)?--([a-z0-9-]+)", said, re.MULTILINE))
    if verb == "compare":  # how scans of other formats are read is left to the program
        offered &= {*WORK, *options, "labels"}
        options = {**options, "labels": PROGRAM}
    assert offered == {*WORK, *options}
    held = parameters_of(method)
    for option, place in options.items():
        if place in NONE_IN_PYTHON:
            continue
        if "." in place:
            place, name = place.rsplit(".", 1)
            assert name in parameters_of(place), option
        else:
            assert place in held, option
