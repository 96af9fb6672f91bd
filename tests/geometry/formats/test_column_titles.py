"""A table's titles say which columns are x, y and z."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import shape_files

from circumspect.errors import InputError
from circumspect.geometry import read_cloud

POINTS = shape_files.POINTS
LABELS = np.ones((len(POINTS), 1))


def table(title: str, columns: list[np.ndarray], delimiter: str = ",") -> str:
    return title + "\n" + shape_files.rows(np.hstack(columns), delimiter)


def read(folder: Path, text: str, name: str = "a.csv") -> np.ndarray:
    path = folder / name
    path.write_text(text)
    return read_cloud(path).points_xyz


@pytest.mark.parametrize("mark", ["", "# ", "#", "//", "// "])
@pytest.mark.parametrize(
    ("title", "delimiter"),
    [
        ("label,x,y,z", ","),
        ("Label, X, Y, Z", ","),
        ('"label","x","y","z"', ","),
        ("label;x;y;z", ";"),
        ("label x y z", " "),
        ("label\tx\ty\tz", "\t"),
        ("point label\tx\ty\tz", "\t"),
        ("label x y z", ","),
        ("label, x, y, z", " "),
        ("point label,x [m],y [m],z [m]", ","),
        ("label x[m] y[m] z[m]", " "),
        ("label,x (m),y (m),z (m)", ";"),
    ],
)
def test_coordinates_are_taken_by_name(mark: str, title: str, delimiter: str, tmp_path: Path):
    points = read(tmp_path, table(mark + title, [LABELS, POINTS], delimiter))
    np.testing.assert_array_equal(points, POINTS)


@pytest.mark.parametrize("title", [",x,y,z", '"",x,y,z', ",z,y,x", "time,z,x,y", "z,y,x,label"])
def test_titles_may_be_in_any_order_and_incomplete(title: str, tmp_path: Path):
    names = title.split(",")
    columns = [
        POINTS[:, ["xyz".index(name)]] if name in ("x", "y", "z") else LABELS for name in names
    ]
    np.testing.assert_array_equal(read(tmp_path, table(title, columns)), POINTS)


def test_titles_as_numpy_writes_them(tmp_path: Path):
    """`savetxt` puts its comment mark in front of the titles."""
    for comments in ("# ", ""):
        np.savetxt(tmp_path / "a.csv", np.hstack([LABELS, POINTS]), delimiter=",",
                   header="label,x,y,z", comments=comments)  # fmt: skip
        np.testing.assert_array_equal(read_cloud(tmp_path / "a.csv").points_xyz, POINTS)


def test_columns_of_text_are_allowed(tmp_path: Path):
    rows = shape_files.rows(POINTS, ",").splitlines()
    text = "name,number,x,y,z\n" + "\n".join(f'"seat, red",7,{row}' for row in rows)
    np.testing.assert_array_equal(read(tmp_path, text), POINTS)


def test_the_last_line_of_titles_is_used(tmp_path: Path):
    titles = "# my scan\nlabel,x,y,z\n# of May\n\n# second run"
    np.testing.assert_array_equal(read(tmp_path, table(titles, [LABELS, POINTS])), POINTS)


@pytest.mark.parametrize(
    "title",
    [
        "my scan",
        "my first scan",
        "my very first scan",
        "x marks the chair",
        "# a chair, scanned in May, by Bob, with care",
        "# note: axes x, y and z, in metres, by Bob",
        "Chair number two, scanned late in May, by Bob, with great care",
        "4",
        "px,py,pz,intensity",
        "x_m;y_m;z_m;label",
        "x,y,z",
        "x y z",
        "X Y Z R G B",
    ],
)
@pytest.mark.parametrize("delimiter", [",", ";", " "])
def test_other_comments_are_ignored(title: str, delimiter: str, tmp_path: Path):
    text = table(title, [POINTS, LABELS], delimiter)
    np.testing.assert_array_equal(read(tmp_path, text, "a.txt"), POINTS)


@pytest.mark.parametrize("title", ["a,b,c", "east,north,up", "my scan, of May, by Bob"])
def test_three_columns_are_the_coordinates_under_any_names(title: str, tmp_path: Path):
    np.testing.assert_array_equal(read(tmp_path, table(title, [POINTS])), POINTS)


@pytest.mark.parametrize("mark", ["", "# "])
@pytest.mark.parametrize(
    ("title", "delimiter"),
    [
        ("label,east,north,up", ","),
        ("label,x,y,height", ","),
        ("nx,ny,nz,curvature", ","),
        ("label;a;b;c", ";"),
        ("label x y height", " "),
    ],
)
def test_other_names_are_refused(mark: str, title: str, delimiter: str, tmp_path: Path):
    with pytest.raises(InputError, match=r"a\.csv: names its columns .*name the coordinates so"):
        read(tmp_path, table(mark + title, [LABELS, POINTS], delimiter))


def test_two_coordinates_are_no_points(tmp_path: Path):
    with pytest.raises(InputError, match="names its columns label, x, y; x, y and z are not all"):
        read(tmp_path, table("label,x,y", [LABELS, POINTS[:, :2]]))


def test_titles_that_are_fewer_than_the_columns_are_refused(tmp_path: Path):
    with pytest.raises(InputError, match=r"names 4 columns \(label, x, y, z\), .* has 5; name"):
        read(tmp_path, table("label,x,y,z", [LABELS, LABELS, POINTS]))


def test_a_row_without_its_coordinate_is_broken(tmp_path: Path):
    with pytest.raises(InputError, match="broken table"):
        read(tmp_path, table("label,x,y,z", [LABELS, POINTS]) + "1,2,3\n")
