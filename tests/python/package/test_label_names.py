"""Names that are given to labels, and those that files have already."""

import numpy as np
import pytest

import octavo

BAD = {
    "of two lines": ({1: "a\nb"}, "name of label 1 holds a control character"),
    "that turns text": ({2: "a\u202eb"}, "name of label 2 holds a control character"),
    "that is empty": ({1: " "}, "label 1 is empty"),
    "that is long": ({1: "\u00e9" * 300}, "longer than 512 bytes"),
    "of no label": ({1 << 32: "a"}, "is no label"),
}


@pytest.mark.parametrize("case", BAD)
def test_what_is_no_name_is_rejected(tmp_path, case):
    names, text = BAD[case]
    with pytest.raises(octavo.ArgumentError, match=text):
        octavo.build(np.zeros((2, 2, 2), bool), tmp_path / "a.8vo", label_names=names)
    with pytest.raises(octavo.ArgumentError, match=text):
        octavo.Writer(tmp_path / "a.8vo", (2, 2, 2), bool, label_names=names)
    assert not list(tmp_path.iterdir())


def test_grey_values_have_no_names(tmp_path):
    with pytest.raises(octavo.ArgumentError, match="no labels to be named.*kind=\"labels\""):
        octavo.build(np.zeros((2, 2, 2), np.int16), tmp_path / "a.8vo", label_names={1: "a"})
    assert not list(tmp_path.iterdir())


def test_labels_that_are_built_again_keep_names_and_colors(run, tmp_path):
    (tmp_path / "names.txt").write_text('1 left 255 128 0\n2 right 0 0 255\n')
    octavo.build(np.arange(24, dtype=np.uint8).reshape(2, 3, 4) % 3, tmp_path / "a.8vo",
                 kind="labels").close()
    done = run("build", tmp_path / "a.8vo", "--label-names", tmp_path / "names.txt", "-o",
               tmp_path / "b.8vo")
    assert done.returncode == 0, done.stderr
    named = octavo.open(tmp_path / "b.8vo")
    again = octavo.build(named, tmp_path / "c.8vo")
    assert again.label_names == {1: "left", 2: "right"}
    assert again.attrs["labels"] == named.attrs["labels"]
    others = octavo.build(named, tmp_path / "d.8vo", label_names={1: "other"})
    assert others.attrs["labels"] == {"1": {"name": "other"}}
    assert "labels" not in octavo.build(named, tmp_path / "e.8vo", label_names={}).attrs
    assert "labels" not in octavo.build(named, tmp_path / "f.8vo", kind="grey").attrs
