"""Arrays become a recording, which fuse_flow.open reads."""

import json
import warnings

import numpy
import pytest

import fuse_flow
from rigs import HEIGHT, WIDTH, at, intrinsics, paint, rough_frame, wall, wall_frame


def reading(path):
    """The frames of a recording of which nothing has to be assumed."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        return list(fuse_flow.open(path))


def assert_same(view, other):
    for name in ("depth", "color", "confidence"):
        image, written = getattr(view, name), getattr(other, name)
        assert (image is None) == (written is None), name
        if image is not None:
            assert image.dtype == written.dtype and numpy.array_equal(image, written, equal_nan=image.dtype.kind == "f"), name


def test_a_recording_has_what_was_written(tmp_path):
    frames = [rough_frame(seed) for seed in range(3)]
    confidence = numpy.random.default_rng(0).random((HEIGHT, WIDTH)).astype(numpy.float32)
    for frame in frames:
        frame.views[1].confidence = confidence
    frames[1].views[0] = None
    cameras = frames[0].cameras
    with fuse_flow.RigWriter(tmp_path / "rig", cameras, 30) as writer:
        for frame in frames:
            writer.write(frame)
    opened = fuse_flow.open(tmp_path / "rig")
    assert opened.frames_per_second == 30 and opened.kind == "rig"
    for camera, written in zip(opened.cameras, cameras):
        assert camera.name == written.name and numpy.array_equal(camera.T_world_camera, written.T_world_camera)
        assert repr(camera.intrinsics) == repr(written.intrinsics)
    back = reading(tmp_path / "rig")
    assert len(back) == 3 and [frame.stamp for frame in back] == [0, 33333, 66667]
    assert back[1].views[0].missing
    for frame, written in zip(back, frames):
        for view, other in zip(frame.views, written.views):
            if other is not None:
                assert_same(view, other)
        assert fuse_flow.FuseFlow().fuse(frame).array.tobytes() == fuse_flow.FuseFlow().fuse(written).array.tobytes()


def test_rows_may_be_parts_of_larger_images(tmp_path):
    random = numpy.random.default_rng(3)
    depth = random.integers(500, 1500, (HEIGHT + 9, WIDTH + 7)).astype(numpy.uint16)[4:-5, 3:-4]
    color = random.integers(0, 256, (HEIGHT, WIDTH + 10, 3)).astype(numpy.uint8)[:, 10:]
    frame = fuse_flow.RigFrame([fuse_flow.Camera(intrinsics(), name="left")], [fuse_flow.DepthView(depth, color)])
    with fuse_flow.RigWriter(str(tmp_path / "rig"), frame.cameras) as writer:
        writer.write(frame)
    assert_same(reading(tmp_path / "rig")[0].views[0], frame.views[0])


def test_depth_in_metres_loses_nothing(tmp_path):
    depth = numpy.random.default_rng(0).random((HEIGHT, WIDTH)).astype(numpy.float32) + 1
    depth[3:9, 5:50] = numpy.nan
    camera = fuse_flow.Camera(intrinsics(), name="left", depth_scale=1)
    frame = fuse_flow.RigFrame([camera], [fuse_flow.DepthView(depth)])
    with fuse_flow.RigWriter(tmp_path / "rig", [camera]) as writer:
        writer.write(frame)
    back = reading(tmp_path / "rig")[0].views[0].depth
    assert back.dtype == numpy.float32
    measured = numpy.isfinite(depth)
    assert numpy.array_equal(back[measured], depth[measured]) and not (back[~measured] > 0).any()
    camera.depth_scale = 0.001
    with fuse_flow.RigWriter(tmp_path / "other", [camera]) as writer:
        with pytest.raises(ValueError, match="depth of camera 'left' is float32, in metres: its depth_scale is 0.001.*, must be 1"):
            writer.write(frame)


def test_a_camera_may_have_colour_alone(tmp_path):
    frame = wall_frame()
    frame.views[1].depth = None
    with fuse_flow.RigWriter(tmp_path / "rig", frame.cameras, has_depth=[True, False]) as writer:
        writer.write(frame)
        with pytest.raises(ValueError, match="depth of camera 'camera 1' is there, but has_depth says it has none"):
            writer.write(wall_frame())
    view = reading(tmp_path / "rig")[0].views[1]
    assert view.missing and numpy.array_equal(view.color, paint())


def test_colour_may_come_later(tmp_path):
    frame = wall_frame()
    frame.views = [fuse_flow.DepthView(wall()), None]
    with fuse_flow.RigWriter(tmp_path / "rig", frame.cameras) as writer:
        writer.write(frame)
        writer.write(wall_frame())
    first, second = fuse_flow.open(tmp_path / "rig")
    assert first.views[0].color is None and first.views[1].missing
    assert all(numpy.array_equal(view.color, paint()) for view in second.views)


def test_frames_come_back_at_the_times_at_which_they_were_taken(tmp_path):
    stamps = [1_700_000_000_000_007, 1_700_000_000_033_340, 1_700_000_000_100_001, 1_700_000_000_133_333]
    with fuse_flow.RigWriter(tmp_path / "rig", wall_frame().cameras) as writer:
        for number, stamp in enumerate(stamps):
            frame = wall_frame()
            frame.stamp = stamp
            if number == 1:
                frame.views[0] = None
            writer.write(frame)
    back = reading(tmp_path / "rig")
    apart = [abs(frame.stamp - stamp) for frame, stamp in zip(back, stamps)]
    assert len(back) == 4 and apart[0] == apart[2] == apart[3] == 0
    assert apart[1] < 100  # what a camera missed is taken to be in the middle of its frames before and after
    assert [frame.views[0].missing for frame in back] == [False, True, False, False]


def test_stamps_that_do_not_rise_are_no_times(tmp_path):
    with fuse_flow.RigWriter(tmp_path / "rig", wall_frame().cameras) as writer:
        for _ in range(3):
            writer.write(wall_frame())
    assert len(reading(tmp_path / "rig")) == 3
    writer = fuse_flow.RigWriter(tmp_path / "back", wall_frame().cameras)
    for stamp in (5, 7, 6):
        frame = wall_frame()
        frame.stamp = stamp
        writer.write(frame)
    with pytest.warns(UserWarning, match="has no times, as the stamps of its frames do not rise"):
        writer.finish()
    assert len(reading(tmp_path / "back")) == 3


def test_frames_have_the_numbers_that_they_are_given(tmp_path):
    with fuse_flow.RigWriter(tmp_path / "rig", wall_frame().cameras, 10) as writer:
        writer.write(wall_frame(), 4)
        writer.write(wall_frame())
    with pytest.warns(UserWarning, match="begins at frame 000004"):
        assert fuse_flow.open(tmp_path / "rig").frames == [4, 5]


def test_a_folder_is_a_recording_once_it_is_finished_also_by_an_exception(tmp_path):
    with pytest.raises(KeyboardInterrupt):
        with fuse_flow.RigWriter(tmp_path / "rig", wall_frame().cameras) as writer:
            writer.write(wall_frame())
            assert not (tmp_path / "rig" / "rig.json").exists()
            raise KeyboardInterrupt
    assert len(reading(tmp_path / "rig")) == 1
    assert len(json.loads((tmp_path / "rig" / "rig.json").read_text())["cameras"]) == 2


def test_what_is_wrong_is_said_before_anything_is_written(tmp_path):
    cameras = wall_frame().cameras
    twins = [fuse_flow.Camera(intrinsics(), name="left"), fuse_flow.Camera(intrinsics(), at(x=1.0), name="left")]
    for wrong, right in [(([],), "there is no camera"),
                         ((twins,), "two cameras are named 'left'"),
                         (([fuse_flow.Camera(intrinsics())],), "camera 0 is named '', must be the name of a folder"),
                         (([fuse_flow.Camera(intrinsics(), name="../left")],), "must be the name of a folder"),
                         ((cameras, 0), "frames_per_second is 0.0.*, must be 0.001 to 1000000")]:
        with pytest.raises(ValueError, match=right):
            fuse_flow.RigWriter(tmp_path / "rig", *wrong)
    with pytest.raises(ValueError, match="has_depth is of 1 cameras, must be of 2"):
        fuse_flow.RigWriter(tmp_path / "rig", cameras, has_depth=[True])
    assert not (tmp_path / "rig").exists()
    with fuse_flow.RigWriter(tmp_path / "rig", cameras) as writer:
        with pytest.raises(ValueError, match="the frame has 3 views, must have 2"):
            writer.write(wall_frame(3))
        frame = wall_frame()
        frame.views[1] = fuse_flow.DepthView(wall()[:50])
        with pytest.raises(ValueError, match="camera 'camera 1'.*160x50, its camera is 160x120"):
            writer.write(frame)
        assert not [path for path in (tmp_path / "rig").rglob("*") if path.is_file()]
        writer.write(wall_frame())
    with pytest.raises(ValueError, match="is a recording already, must be a new folder"):
        fuse_flow.RigWriter(tmp_path / "rig", cameras)
    (tmp_path / "file").write_text("")
    with pytest.raises(OSError, match="file"):
        fuse_flow.RigWriter(tmp_path / "file" / "rig", cameras)
