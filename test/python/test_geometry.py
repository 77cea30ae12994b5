"""What is fused, of geometry that is known by hand."""

import numpy
import pytest

import fuse_flow
from rigs import FOCAL, WIDTH, at, intrinsics, wall, wall_frame


def test_a_wall_one_metre_away_is_a_plane_of_its_colour():
    cloud = fuse_flow.FuseFlow().fuse(wall_frame())
    assert len(cloud) > 1000
    assert cloud.points.shape == (len(cloud), 3) and cloud.points.dtype == numpy.float32
    assert numpy.abs(cloud.points[:, 2] - 1).max() < 1e-5
    assert (cloud.colors == (200, 120, 40)).all()
    half_width = (WIDTH - 1) / 2 / FOCAL
    assert cloud.points[:, 0].min() == pytest.approx(-half_width, abs=0.02)
    assert cloud.points[:, 0].max() == pytest.approx(half_width + 0.05, abs=0.02)


@pytest.mark.parametrize("dtype", [numpy.uint16, numpy.float32])
def test_millimetres_and_metres_are_the_same_wall(dtype):
    points = fuse_flow.FuseFlow().fuse(wall_frame(dtype=dtype)).points
    assert numpy.abs(points[:, 2] - 1).max() < 1e-5


def test_depth_scale_is_metres_per_unit():
    frame = wall_frame()
    for camera in frame.cameras:
        camera.depth_scale = 0.0005
    assert numpy.abs(fuse_flow.FuseFlow().fuse(frame).points[:, 2] - 0.5).max() < 1e-5


def test_the_pose_takes_points_from_the_camera_to_the_world():
    pose = numpy.array([[0, 0, 1, 3], [0, 1, 0, 0], [-1, 0, 0, 0], [0, 0, 0, 1]], float)  # z of the camera is x of the world
    frame = fuse_flow.RigFrame([fuse_flow.Camera(intrinsics(), pose)], [fuse_flow.DepthView(wall())])
    points = fuse_flow.FuseFlow().fuse(frame).points
    assert numpy.abs(points[:, 0] - 4).max() < 1e-5


def test_cameras_that_see_the_same_are_counted_and_named():
    cloud = fuse_flow.FuseFlow(camera_mask=True).fuse(wall_frame())
    middle = numpy.abs(cloud.points[:, 0]) < 0.3
    assert (cloud.view_count[middle] == 2).all()
    assert (cloud.camera_mask[middle] == (3, 0)).all()
    assert ((cloud.confidence > 0) & (cloud.confidence <= 1)).all()


def test_normals_face_the_cameras():
    cloud = fuse_flow.FuseFlow(normals=True).fuse(wall_frame())
    known = numpy.isfinite(cloud.normals).all(axis=1)
    assert known.mean() > 0.9
    assert numpy.abs(cloud.normals[known] - (0, 0, -1)).max() < 1e-3


def test_what_was_not_asked_for_says_how_to_ask():
    cloud = fuse_flow.FuseFlow().fuse(wall_frame())
    with pytest.raises(AttributeError, match="normals=True"):
        cloud.normals
    with pytest.raises(AttributeError, match="camera_mask=True"):
        cloud.camera_mask


def test_the_same_points_come_with_and_without_extras():
    plain = fuse_flow.FuseFlow().fuse(wall_frame())
    for extras in ({"normals": True}, {"camera_mask": True}, {"normals": True, "camera_mask": True}):
        more = fuse_flow.FuseFlow(**extras).fuse(wall_frame())
        for name in plain.array.dtype.names:
            assert numpy.array_equal(plain.array[name], more.array[name]), (extras, name)


def test_the_structured_array_has_the_names_of_the_point_and_the_same_memory():
    cloud = fuse_flow.FuseFlow().fuse(wall_frame())
    array = cloud.array
    assert array.dtype.names == ("x", "y", "z", "rgba", "confidence", "view_count")
    assert array.dtype.itemsize == 32
    array["x"][0] = 7
    assert cloud.points[0, 0] == 7
    assert (array["rgba"] == 0xFF000000 + (200 << 16) + (120 << 8) + 40).all()


def test_a_camera_without_a_view_is_skipped_and_named():
    fusion = fuse_flow.FuseFlow()
    frame = wall_frame()
    frame.views[1] = None
    cloud = fusion.fuse(frame)
    assert fusion.statistics.missing_cameras == [1]
    assert (cloud.view_count == 1).all()
    frame.views[0] = fuse_flow.DepthView()
    assert len(fusion.fuse(frame)) == 0 and fusion.statistics.missing_cameras == [0, 1]


def test_a_cloud_without_points_has_arrays_without_rows():
    cloud = fuse_flow.FuseFlow(normals=True, camera_mask=True).fuse(
        fuse_flow.RigFrame([fuse_flow.Camera(intrinsics())], [None]))
    assert cloud.points.shape == (0, 3) and cloud.colors.shape == (0, 3) and cloud.array.shape == (0,)
    assert cloud.normals.shape == (0, 3) and cloud.camera_mask.shape == (0, 2)


def test_the_stamp_goes_into_the_cloud():
    frame = wall_frame()
    frame.stamp = 1234567890123456
    assert fuse_flow.FuseFlow().fuse(frame).stamp == 1234567890123456


def test_a_colour_camera_of_its_own_has_images_of_its_own_size():
    camera = fuse_flow.Camera(intrinsics())
    camera.color = fuse_flow.ColorCamera(intrinsics=fuse_flow.Intrinsics(320, 240, 262.5, 262.5, 159.5, 119.5))
    camera.color.T_depth_color = at(x=0.02)
    color = numpy.full((240, 320, 3), (10, 20, 30), numpy.uint8)
    cloud = fuse_flow.FuseFlow().fuse(fuse_flow.RigFrame([camera], [fuse_flow.DepthView(wall(), color)]))
    assert (cloud.colors[numpy.abs(cloud.points[:, 0]) < 0.3] == (10, 20, 30)).all()


def test_depth_in_the_wrong_unit_is_warned_of_in_the_words_of_the_tools():
    frame = fuse_flow.RigFrame([fuse_flow.Camera(intrinsics(), name="left")], [fuse_flow.DepthView(wall(1000.0, numpy.float32))])
    with pytest.warns(UserWarning, match="camera 'left' measures nothing within 0.1 to 20 m, but 1000 to 1000 m"):
        fuse_flow.FuseFlow().fuse(frame)


def test_a_camera_without_a_name_is_called_by_its_number():
    views = [fuse_flow.DepthView(wall()), fuse_flow.DepthView(wall(1000.0, numpy.float32))]
    frame = fuse_flow.RigFrame([fuse_flow.Camera(intrinsics()) for _ in views], views)
    with pytest.warns(UserWarning, match="camera '1' measures nothing .* but 1000 to 1000 m; depth in float is metres"):
        fuse_flow.FuseFlow().fuse(frame)
    assert [camera.name for camera in frame.cameras] == ["", ""]


def test_the_number_of_threads_changes_no_byte():
    one = fuse_flow.FuseFlow(threads=1).fuse(wall_frame())
    three = fuse_flow.FuseFlow(threads=3).fuse(wall_frame())
    assert one.array.tobytes() == three.array.tobytes()


def test_poses_of_another_convention_are_named():
    """Two cameras around a slanted wall: their images agree, until the poses mean something else."""
    poses = []
    for angle in (-0.35, 0.35):
        pose = numpy.eye(4)
        c, s = numpy.cos(angle), numpy.sin(angle)
        pose[:3, :3] = [[c, 0, s], [0, 1, 0], [-s, 0, c]]
        pose[:3, 3] = numpy.array([0, 0, 2.0]) - 2.0 * pose[:3, 2]
        poses.append(pose)
    normal, offset = numpy.array([0.1, 0.2, 1.0]), 2.2
    v, u = numpy.mgrid[:120, :160]
    rays = numpy.stack([(u - 79.5) / 150, (v - 59.5) / 150, numpy.ones((120, 160))], axis=-1)
    depths = [((offset - pose[:3, 3] @ normal) / (rays @ pose[:3, :3].T @ normal)).astype(numpy.float32) for pose in poses]
    K = fuse_flow.Intrinsics(160, 120, 150, 150, 79.5, 59.5)

    def said(change):
        cameras = [fuse_flow.Camera(K, change(pose)) for pose in poses]
        return "\n".join(fuse_flow.check_poses(fuse_flow.RigFrame(cameras, [fuse_flow.DepthView(depth) for depth in depths])))

    assert said(lambda pose: pose) == ""
    assert "numpy.linalg.inv(pose)" in said(numpy.linalg.inv)
    assert "OpenGL" in said(lambda pose: pose @ numpy.diag([1, -1, -1, 1]))

    def in_millimetres(pose):
        return numpy.block([[pose[:3, :3], 1000 * pose[:3, 3:]], [numpy.zeros((1, 3)), 1]])

    assert "camera '0': another camera could see 0 % of its points" in said(in_millimetres)


def test_poses_of_which_nothing_is_known_are_said_not_to_be():
    far, near = fuse_flow.DepthView(wall(1000.0, numpy.float32)), fuse_flow.DepthView(wall())
    for views in ([near], [near, None], [near, far], [far, far]):
        frame = fuse_flow.RigFrame([fuse_flow.Camera(intrinsics()) for _ in views], views)
        assert fuse_flow.check_poses(frame) == [
            "nothing is known of the poses: fewer than two cameras measure anything within 0.1 to 20 m"
        ]
    assert fuse_flow.check_poses(fuse_flow.RigFrame([fuse_flow.Camera(intrinsics()) for _ in "ab"], [near, near])) == []
