"""Cameras and parameters as plain attributes."""

import copy

import numpy
import pytest

import fuse_flow
from rigs import at, intrinsics, wall_frame


def test_nested_attributes_are_set_where_they_are():
    fusion = fuse_flow.FuseFlow()
    fusion.parameters.aggregation.min_cell_size = 0.03
    coarse = len(fusion.fuse(wall_frame()))
    assert fusion.parameters.aggregation.min_cell_size == pytest.approx(0.03)
    assert coarse < len(fuse_flow.FuseFlow().fuse(wall_frame())) / 3


def test_parameters_are_made_by_name_and_copied():
    parameters = fuse_flow.FuseFlowParameters(
        max_noise=0.05, gate_noise=0.01, confidence=fuse_flow.ConfidenceParameters(threshold=0.5)
    )
    other = copy.deepcopy(parameters)
    other.confidence.threshold = 0.7
    assert parameters.confidence.threshold == 0.5 and other.max_noise == pytest.approx(0.05)
    assert other.gate_noise == pytest.approx(0.01)
    with pytest.raises(TypeError, match="FuseFlowParameters has no max_nose"):
        fuse_flow.FuseFlowParameters(max_nose=0.05)


def test_a_parameter_that_does_not_exist_is_no_attribute():
    with pytest.raises(AttributeError):
        fuse_flow.FuseFlowParameters().confidence.treshold = 0.5


def test_published_and_estimated_depth_are_those_of_the_library():
    assert fuse_flow.FuseFlowParameters.published().confidence.form == fuse_flow.ConfidenceForm.PUBLISHED
    assert fuse_flow.FuseFlowParameters().confidence.form == fuse_flow.ConfidenceForm.SLOPE_COMPENSATED
    assert fuse_flow.FuseFlowParameters.estimated_depth().agreement.min_views == 2


def test_a_value_out_of_range_is_named():
    parameters = fuse_flow.FuseFlowParameters()
    parameters.confidence.threshold = 2
    for use in (parameters.check, lambda: fuse_flow.FuseFlow(parameters=parameters)):
        with pytest.raises(ValueError, match="threshold is 2"):
            use()
    fusion = fuse_flow.FuseFlow()
    fusion.parameters.confidence.threshold = 2
    with pytest.raises(ValueError, match="threshold is 2"):
        fusion.fuse(wall_frame())
    fusion.parameters.confidence.threshold = 0.6
    assert len(fusion.fuse(wall_frame())) > 0


def test_no_point_lies_outside_the_crop_box():
    fusion = fuse_flow.FuseFlow()
    fusion.parameters.crop_box = ((-0.1, -0.2, 0.5), (0.2, 0.1, 1.5))
    points = fusion.fuse(wall_frame()).points
    assert len(points) > 100
    assert (points.min(axis=0) >= (-0.1, -0.2, 0.5)).all() and (points.max(axis=0) <= (0.2, 0.1, 1.5)).all()
    low, high = fusion.parameters.crop_box
    assert numpy.allclose(low, (-0.1, -0.2, 0.5)) and numpy.allclose(high, (0.2, 0.1, 1.5))
    fusion.parameters.crop_box = None
    assert fusion.parameters.crop_box is None


def test_a_pose_is_a_matrix_that_nobody_writes_into_by_mistake():
    camera = fuse_flow.Camera(intrinsics(), at(x=1))
    assert numpy.array_equal(camera.T_world_camera, at(x=1))
    with pytest.raises(ValueError, match="read-only"):
        camera.T_world_camera[0, 3] = 2
    camera.T_world_camera = at(x=2).tolist()
    assert camera.T_world_camera[0, 3] == 2


@pytest.mark.parametrize("pose, message", [
    (numpy.eye(3), r"T_world_camera is of shape \(3, 3\), must be \(4, 4\)"),
    (numpy.ones((4, 4)), "the last row must be 0 0 0 1"),
    (numpy.diag([2.0, 1, 1, 1]), "T_world_camera is not rigid"),
    (numpy.diag([1.0, 1, numpy.nan, 1]), "not finite"),
    ("north", "must be numbers"),
])
def test_a_pose_that_is_none_is_refused(pose, message):
    with pytest.raises(ValueError, match=message):
        fuse_flow.Camera(intrinsics(), pose)


def test_what_a_camera_may_have_is_none_until_it_is_set_and_changes_in_place():
    camera = fuse_flow.Camera(intrinsics())
    assert camera.noise is None and camera.color is None
    camera.noise = fuse_flow.NoiseModel.stereo(600, 0.05, 0.1)
    camera.noise.floor = 0.002
    assert camera.noise.floor == pytest.approx(0.002)
    assert camera.noise.quadratic == pytest.approx(0.1 / (600 * 0.05))
    camera.noise = None
    assert camera.noise is None


def test_a_camera_that_contradicts_itself_is_named():
    camera = fuse_flow.Camera(intrinsics(), name="left")
    camera.intrinsics.fx = 0
    with pytest.raises(ValueError, match=r"fuse_flow.Camera 'left': fx is 0, must be positive"):
        camera.check()


def test_distortion_has_the_order_of_calibration_tools():
    distortion = fuse_flow.Distortion([0.1, 0.2, 0.3, 0.4, 0.5])
    assert [getattr(distortion, name) for name in ("k1", "k2", "p1", "p2", "k3", "k6")] == pytest.approx(
        [0.1, 0.2, 0.3, 0.4, 0.5, 0])
    with pytest.raises(ValueError, match="8 coefficients at most"):
        fuse_flow.Distortion([0] * 9)


def test_a_depth_correction_is_of_two_grids():
    correction = fuse_flow.DepthCorrection(numpy.full((3, 4), 0.01), numpy.zeros((3, 4)))
    assert (correction.rows, correction.columns) == (3, 4)
    assert correction.relative.shape == (3, 4)
    frame = wall_frame()
    for camera in frame.cameras:
        camera.depth_correction = correction
    assert numpy.abs(fuse_flow.FuseFlow().fuse(frame).points[:, 2] - 1.01).max() < 1e-5
    with pytest.raises(ValueError, match="one shape"):
        fuse_flow.DepthCorrection(numpy.zeros((3, 4)), numpy.zeros((4, 3)))


def test_every_class_and_attribute_has_a_sentence():
    for name, value in vars(fuse_flow).items():
        if name.startswith("_") or not isinstance(value, type):
            continue
        assert value.__doc__, name
        for attribute, found in vars(value).items():
            if type(found) is property and not hasattr(value, "__members__"):
                assert found.__doc__, f"{name}.{attribute}"


def test_what_was_not_built_is_said_where_it_is_asked_for():
    with pytest.raises(AttributeError, match="has no attribute 'Nothing'$"):
        fuse_flow.Nothing
    if hasattr(fuse_flow, "StreamServer"):
        with pytest.raises(AttributeError, match="has no attribute 'StreamNothing'$"):
            fuse_flow.StreamNothing
    else:
        with pytest.raises(AttributeError, match="'StreamServer': it was built without streams, which need Boost, OpenSSL"):
            fuse_flow.StreamServer
