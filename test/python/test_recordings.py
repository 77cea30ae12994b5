"""Recordings: for frame in fuse_flow.open(path)."""

import json
import pathlib
import shutil
import warnings

import numpy
import pytest

import fuse_flow


def test_a_recording_is_its_frames(recording):
    opened = fuse_flow.open(recording)
    assert opened.kind == "rig" and len(opened) == 3 and opened.frames == [0, 1, 2]
    assert opened.frames_per_second == 5
    frames = list(opened)
    assert [frame.stamp for frame in frames] == sorted({frame.stamp for frame in frames})
    described = json.loads((recording / "rig.json").read_text())["cameras"]
    assert [camera.name for camera in opened.cameras] == [camera["name"] for camera in described]
    for frame in frames:
        assert len(frame.cameras) == len(frame.views) == 4
        for camera, view in zip(frame.cameras, frame.views):
            assert view.depth.shape == (camera.intrinsics.height, camera.intrinsics.width)
            assert view.depth.dtype == numpy.uint16 and view.color.dtype == numpy.uint8


def test_arrays_of_a_frame_stay_when_the_next_one_is_read(recording):
    opened = fuse_flow.open(str(recording))
    depth = opened.read(0).views[0].depth
    before = depth.copy()
    for _ in range(3):
        list(opened)
    assert numpy.array_equal(depth, before)
    assert not numpy.array_equal(opened.read(2).views[0].depth, before)


def test_reading_again_and_again_leaves_no_memory(recording):
    from test_lifetime import resident_kilobytes

    opened = fuse_flow.open(recording)
    for _ in range(20):
        list(opened)
    before = resident_kilobytes()
    for _ in range(200):
        list(opened)
    assert resident_kilobytes() - before < 4096


def test_some_cameras_and_no_colour_if_so_asked(recording):
    opened = fuse_flow.open(recording, views="0,2", read_color=False)
    frame = next(iter(opened))
    assert len(frame.cameras) == 2 and frame.views[0].color is None


def test_what_is_wrong_is_said_in_the_words_of_python(recording, tmp_path):
    with pytest.raises(ValueError, match="nowhere"):
        fuse_flow.open(tmp_path / "nowhere")
    with pytest.raises(ValueError, match="^slide"):
        fuse_flow.open(recording, slide=2)
    with pytest.raises(IndexError, match="frame 7 does not exist"):
        fuse_flow.open(recording).read(7)


def damaged(recording, tmp_path):
    copy = tmp_path / "damaged"
    shutil.copytree(recording, copy)
    image = sorted(path for path in pathlib.Path(copy).rglob("*.png") if "depth" in str(path))[0]
    image.write_bytes(image.read_bytes()[:100])
    return copy


def test_a_damaged_file_is_an_error_or_where_that_is_asked_for_a_warning(recording, tmp_path):
    copy = damaged(recording, tmp_path)
    with pytest.raises(ValueError, match=r"\.png"):
        list(fuse_flow.open(copy))
    with pytest.warns(UserWarning, match=r"\.png"):
        frames = list(fuse_flow.open(copy, skip_damaged=True))
    assert sum(view.missing for frame in frames for view in frame.views) == 1


def test_what_was_assumed_is_warned_of(recording, tmp_path):
    copy = tmp_path / "unknown_key"
    shutil.copytree(recording, copy)
    described = json.loads((copy / "rig.json").read_text())
    described["cameras"][0]["colour_of_its_case"] = "grey"
    (copy / "rig.json").write_text(json.dumps(described))
    with pytest.warns(UserWarning, match="colour_of_its_case"):
        opened = fuse_flow.open(copy)
    assert any("colour_of_its_case" in line for line in opened.warnings)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        fuse_flow.open(recording)
