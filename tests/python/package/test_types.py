"""The types that the package declares, beside what it has, and what mypy makes of them."""

import ast
import inspect
import os
import pathlib
import subprocess
import sys

import pytest

import octavo

STUB = pathlib.Path(octavo.__file__).with_name("__init__.pyi")
TREE = ast.parse(STUB.read_text())
CLASSES = {node.name: node for node in TREE.body if isinstance(node, ast.ClassDef)}
FUNCTIONS = {node.name: node for node in TREE.body if isinstance(node, ast.FunctionDef)}
OPERATORS = ("__init__", "__len__", "__bool__", "__getitem__", "__array__", "__enter__", "__exit__",
             "__and__", "__or__", "__sub__", "__xor__", "__invert__")


def is_declared(name):
    return not name.startswith("_") or name in OPERATORS


def members_declared(name):
    """What a class of the stub has, with what it has from the stub's other classes."""
    members = {}
    for base in CLASSES[name].bases:
        if isinstance(base, ast.Name) and base.id in CLASSES:
            members |= members_declared(base.id)
    for node in CLASSES[name].body:
        if isinstance(node, ast.FunctionDef):
            members[node.name] = node
        elif isinstance(node, ast.AnnAssign):
            members[node.target.id] = None
    return members


def members_held(held):
    members = {}
    for part in held.__mro__[::-1]:
        if part.__module__.startswith("octavo"):
            members |= {name: value for name, value in vars(part).items() if is_declared(name)}
    return members


def parameters_declared(node):
    """Kind, name and default of each; ... stands for any default."""
    given = node.args
    defaults = [None] * (len(given.args) - len(given.defaults)) + given.defaults
    found = [("either", arg.arg, default) for arg, default in zip(given.args, defaults)]
    if given.vararg:
        found.append(("several", given.vararg.arg, None))
    found += [("named", arg.arg, default)
              for arg, default in zip(given.kwonlyargs, given.kw_defaults)]
    if given.kwarg:
        found.append(("rest", given.kwarg.arg, None))
    return [(kind, name, None if default is None else ast.literal_eval(default))
            for kind, name, default in found]


def parameters_held(function):
    kinds = dict(zip(("POSITIONAL_OR_KEYWORD", "VAR_POSITIONAL", "KEYWORD_ONLY", "VAR_KEYWORD"),
                     ("either", "several", "named", "rest")))
    return [(kinds[one.kind.name], one.name,
             None if one.default is inspect.Parameter.empty or one.default is None else one.default)
            for one in inspect.signature(function).parameters.values()]


def expect_alike(where, node, function):
    declared, held = parameters_declared(node), parameters_held(function)
    assert [one[:2] for one in declared] == [one[:2] for one in held], where
    for (_, name, said), (_, _, true) in zip(declared, held):
        assert said is ... or said == true, (where, name)


def test_every_public_name_is_declared():
    declared = {name for name in [*CLASSES, *FUNCTIONS] if not name.startswith("_")}
    assert declared == set(octavo.__all__)


@pytest.mark.parametrize("name", sorted(set(FUNCTIONS)))
def test_functions_have_the_parameters_that_are_declared(name):
    expect_alike(name, FUNCTIONS[name], getattr(octavo, name))


@pytest.mark.parametrize("name", sorted(n for n in CLASSES if not n.startswith("_")))
def test_classes_have_the_members_that_are_declared(name):
    declared, held = members_declared(name), members_held(getattr(octavo, name))
    # Views are made by volumes alone.
    made_by_others = {"__init__"} if name in ("View", "RealView") else set()
    assert set(held) - set(declared) == made_by_others
    for key, node in declared.items():
        value = held.get(key)
        if node is None:
            continue
        assert key in held, key
        is_property = any(isinstance(d, ast.Name) and d.id == "property"
                          for d in node.decorator_list)
        assert is_property == (not inspect.isfunction(value)), key
        # The last of several overloads differs in what is needed alone.
        is_overload = any(isinstance(d, ast.Name) and d.id == "overload"
                          for d in node.decorator_list)
        if not is_property and not is_overload:
            expect_alike(f"{name}.{key}", node, value)


def test_volumes_and_masks_have_the_attributes_that_are_declared(volume):
    mask = volume.threshold(0)
    for held in (volume, volume.levels[1], volume.real, mask):
        for name, node in members_declared(type(held).__name__).items():
            if node is None:
                assert hasattr(held, name), (type(held).__name__, name)


PROGRAM = """
import octavo
import octavo.sitk
v = octavo.open("scan.8vo")
bone: octavo.LabelMap = ~v.threshold(226).dilate(mm=2) & v.mask()
rows: list[dict[str, object]] = bone.measure(of=v, progress=True)
spacing: tuple[float, float, float] = v.levels[1].spacing
vertices, faces, facts = bone.surface(space="ras")
far = bone.distance()
far.max() + v.real.at_mm((1, 2, 3))
with octavo.Writer("new.8vo", (1, 2, 3), "uint16", unit="HU") as w:
    w.add(v[0])
try:
    bone.distance("far.8vo", max_mm=2).levels
except octavo.StorageError as error:
    print(error.kind, error.path.upper())
"""
WRONG = ["octavo.open(3)", "v.threshold('bone')", "bone.dilate(mms=2)", "v.levels + 1",
         "octavo.build(v, 'n.8vo', preset='tiny')", "bone.threshold(1)", "v.spacing.mm"]


def test_mypy_takes_right_calls_and_no_wrong_ones(tmp_path):
    pytest.importorskip("mypy")
    program = tmp_path / "program.py"
    program.write_text(PROGRAM + "\n".join(WRONG) + "\n")
    done = subprocess.run(
        [sys.executable, "-m", "mypy", "--strict", "--ignore-missing-imports",
         "--allow-untyped-calls", "--follow-imports=silent", str(program)],
        capture_output=True, text=True, check=False, cwd=tmp_path,
        env={**os.environ, "MYPYPATH": str(STUB.parents[1])})
    first = PROGRAM.count("\n") + 1
    lines = {int(line.split(":")[1]) for line in done.stdout.splitlines() if ": error:" in line}
    assert lines == set(range(first, first + len(WRONG))), done.stdout + done.stderr
