"""Cloud files are read whole or refused; filters do what they say; pictures are drawn without a display."""

import os

import numpy as np
import pytest

from mmt_drake.cloud import Cloud, plane
from mmt_drake.cloud.files import read_cloud, thinned, write_cloud
from mmt_drake.errors import BadInput

CLOUD = plane(2000, noise=1e-4, seed=1).moved((0.01, 0.0, 0.0), 3.0)


@pytest.mark.parametrize(("ending", "within"), [(".ply", 0.0), (".pcd", 2e-8), (".xyz", 1e-9)])
def test_what_is_written_is_read_again(tmp_path, ending, within):
    path = tmp_path / f"surface{ending}"
    write_cloud(CLOUD, path)
    read = read_cloud(path)
    np.testing.assert_allclose(read.points(), CLOUD.points(), atol=within, rtol=0)
    assert [file.name for file in tmp_path.iterdir()] == [path.name]


def text_pcd(rows, points):
    head = "VERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\n"
    return f"{head}WIDTH {points}\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS {points}\nDATA ascii\n" + rows


def test_a_text_pcd_is_read(tmp_path):
    (tmp_path / "a.pcd").write_text(text_pcd("0 0 1\n0 2 0\n", 2))
    np.testing.assert_array_equal(read_cloud(tmp_path / "a.pcd").points(), [[0, 0, 1], [0, 2, 0]])


@pytest.mark.parametrize(
    ("name", "content", "said"),
    [
        ("a.xyz", "", "no points"),
        ("a.xyz", "hello\n", "no points"),
        ("a.xyz", "0 0 0\n1 2\n3 4 5\n", "line 2"),
        ("a.xyz", "0 0 0\n1 2 x\n", "line 2"),
        ("a.xyz", "0 0 0\n1 nan 2\n", "point 1"),
        ("a.ply", "hello\n", "a header without an end"),
        ("a.ply", "ply\nformat binary_little_endian 1.0\ncomment", "a header without an end"),
        ("a.ply", "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
                  "end_header\n0 0 0\n1 1", "cannot read"),
        ("a.pcd", "hello\n", "POINTS: found nothing"),
        ("a.pcd", text_pcd("0 0 1\n0 2", 2), "line 12"),
        ("a.pcd", text_pcd("0 0 1\n0 2 0\n", 5), "2 rows"),
        ("a.pcd", text_pcd("0 0 1\nnan 2 0\n", 2), "point 1"),
        ("a.las", "", "ending in '.las'"),
    ],
)  # fmt: skip
def test_a_file_that_is_no_whole_cloud_is_refused_in_one_line(tmp_path, name, content, said):
    path = tmp_path / name
    path.write_text(content)
    with pytest.raises(BadInput) as error:
        read_cloud(path)
    assert said in str(error.value)
    assert name in str(error.value)
    assert "\n" not in str(error.value)


@pytest.mark.parametrize("ending", [".ply", ".pcd", ".xyz"])
def test_a_file_cut_short_is_refused(tmp_path, ending):
    path = tmp_path / f"surface{ending}"
    write_cloud(CLOUD, path)
    path.write_bytes(path.read_bytes()[: path.stat().st_size * 2 // 3 + 1])
    with pytest.raises(BadInput):
        read_cloud(path)


def test_a_missing_file_or_folder_is_refused(tmp_path):
    with pytest.raises(BadInput, match="no such file"):
        read_cloud(tmp_path / "none.ply")
    with pytest.raises(BadInput, match="folder"):
        write_cloud(CLOUD, tmp_path / "none" / "a.ply")
    with pytest.raises(BadInput, match="ending in"):
        write_cloud(CLOUD, tmp_path / "a.txt")


def test_thinning_leaves_one_mean_a_cube():
    cloud = Cloud([[0.1e-3, 0, 0], [0.3e-3, 0, 0], [5e-3, 0, 0]])
    np.testing.assert_allclose(sorted(thinned(cloud, 1e-3).points()[:, 0]), [0.2e-3, 5e-3])
    for voxel in (0.0, 1e-13):
        with pytest.raises(BadInput, match="voxel"):
            thinned(cloud, voxel)


def test_a_ply_that_is_cut_off_is_told_once_and_stderr_works_again(tmp_path, capfd):
    path = tmp_path / "cut.ply"
    write_cloud(Cloud(np.zeros((50, 3))), path)
    path.write_bytes(path.read_bytes()[:-20])
    with pytest.raises(BadInput, match="cannot read to the end"):
        read_cloud(path)
    os.write(2, b"after")
    assert capfd.readouterr().err == "after"


@pytest.mark.parametrize(
    ("name", "header"),
    [
        ("cloud.ply", "ply\nformat ascii 1.0\nelement vertex 1000000000\nproperty double x\nend_header\n0\n"),
        ("cloud.pcd", "VERSION 0.7\nFIELDS x y z\nWIDTH 1000000000\nHEIGHT 1\nPOINTS 1000000000\nDATA ascii\n0 0 0\n"),
    ],
)
def test_no_room_is_made_for_points_that_a_file_cannot_hold(tmp_path, name, header):
    (tmp_path / name).write_text(header)
    with pytest.raises(BadInput, match=r"found 1000000000 elements in \d\d bytes"):
        read_cloud(tmp_path / name)


PLY = "ply\nformat binary_little_endian 1.0\nelement vertex {}\nproperty uchar x\nend_header\n"


@pytest.mark.parametrize(
    ("name", "header", "size", "found"),
    [
        ("a.xyz", "", 12 * 10**9, r"1\.144e\+04 MiB, expected at most 64 MiB"),
        ("a.ply", PLY.format(4 * 10**8), 10 * 10**9, "9537 MiB, expected at most 64 MiB"),
        ("a.ply", PLY.format(6 * 10**7), 1 << 26, "60000000 elements, expected at most 5000000"),
    ],
)
def test_a_cloud_larger_than_a_table_needs_is_refused_before_it_is_read(tmp_path, name, header, size, found):
    (tmp_path / name).write_text(header)
    os.truncate(tmp_path / name, size)
    with pytest.raises(BadInput, match=found):
        read_cloud(tmp_path / name)


@pytest.mark.parametrize(
    ("size", "points", "message"),
    [
        ("4 4 4", "", "POINTS: found nothing, expected how many"),
        ("4 4 4", "POINTS -2\n", "POINTS: found -2"),
        ("4 4 400000", "POINTS 2\n", "SIZE: found 400000, expected 1, 2, 4 or 8 bytes"),
    ],
)
def test_a_pcd_header_that_open3d_would_read_beyond_the_file_for_is_refused(tmp_path, size, points, message):
    header = f"VERSION 0.7\nFIELDS x y z\nSIZE {size}\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 2\nHEIGHT 1\n{points}DATA ascii\n"
    (tmp_path / "a.pcd").write_text(header + "0 0 0\n1 1 1\n")
    with pytest.raises(BadInput, match=message):
        read_cloud(tmp_path / "a.pcd")
