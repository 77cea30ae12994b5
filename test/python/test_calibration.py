"""Poses and depth corrections, of a corner of a room whose geometry is known."""

import numpy
import pytest

import fuse_flow
from scenes import apart, corner_frame, moved, poses_of


def disturbed(frame):
    poses = poses_of(frame)
    poses[1] = moved(poses[1], (0.012, -0.011, 0.012), 1.0, (1, 2, -1))
    poses[2] = moved(poses[2], (-0.01, 0.014, -0.009), -0.8, (2, 1, 1))
    return poses


def test_cameras_some_centimetres_off_come_back():
    frame = corner_frame()
    estimation = fuse_flow.ExtrinsicEstimation()
    estimation.add_frame(frame)
    begin = disturbed(frame)
    result = estimation.estimate(begin)
    assert result.converged and result.T_world_camera.shape == (4, 4, 4)
    for found, truth, correction in zip(result.T_world_camera, poses_of(frame), result.corrections):
        assert apart(found, truth) < 0.001
        assert correction.constrained and correction.free_directions.shape == (0, 6) and correction.covariance.shape == (6, 6)
    assert result.corrections[1].translation == pytest.approx(apart(begin[1], poses_of(frame)[1]), abs=0.001)
    assert result.residual < 0.2 * result.residual_before
    assert {(overlap.first, overlap.second) for overlap in result.overlaps} <= {(i, j) for i in range(4) for j in range(4) if i < j}


def test_without_a_frame_there_is_nothing_to_estimate():
    for estimation in (fuse_flow.ExtrinsicEstimation(), fuse_flow.CoarseAlignment(), fuse_flow.DepthCorrectionEstimation()):
        with pytest.raises(RuntimeError):
            estimation.estimate()
        estimation.add_frame(corner_frame())
        estimation.clear()
        with pytest.raises(RuntimeError):
            estimation.estimate()


def test_wrong_poses_and_parameters_are_refused():
    estimation = fuse_flow.ExtrinsicEstimation()
    estimation.add_frame(corner_frame())
    with pytest.raises(ValueError, match=r"initial is of shape \(4, 4\), must be \(N, 4, 4\)"):
        estimation.estimate(numpy.eye(4))
    with pytest.raises(ValueError):
        estimation.estimate(numpy.stack([numpy.eye(4)] * 3))
    estimation.parameters.samples = 3
    with pytest.raises(ValueError, match="samples is 3"):
        estimation.estimate()
    with pytest.raises(ValueError, match="initial"):
        fuse_flow.DepthCorrectionEstimation().estimate(refined=[numpy.eye(4)])


def test_tracking_follows_a_camera_that_drifts():
    frame = corner_frame()
    truth = poses_of(frame)
    frame.cameras[1].T_world_camera = moved(truth[1], (0.006, -0.005, 0.004), 0.3)
    tracking = fuse_flow.ExtrinsicTracking(frame.cameras)
    assert tracking.poses.updates == 0
    for k in range(6):
        frame.stamp = 40000 * (k + 1)
        assert tracking.push(frame)
        tracking.finish()
        tracking.apply(frame)
    assert tracking.poses.updates == 6 and tracking.poses.stamp == 240000
    relative = numpy.linalg.inv(frame.cameras[0].T_world_camera) @ frame.cameras[1].T_world_camera
    assert apart(relative, numpy.linalg.inv(truth[0]) @ truth[1]) < 0.002
    with pytest.raises(ValueError, match="has 1 cameras, the rig 4"):
        tracking.apply(fuse_flow.RigFrame(frame.cameras[:1], [None]))


def test_a_correction_is_found_that_bends_a_camera_back():
    frame = corner_frame()
    wrong = frame.views[1].depth.copy()
    wrong *= numpy.linspace(1.01, 0.99, wrong.shape[1], dtype=numpy.float32)
    frame.views[1].depth = wrong
    estimation = fuse_flow.DepthCorrectionEstimation()
    estimation.add_frame(frame)
    result = estimation.estimate()
    assert result.residual < 0.6 * result.residual_before
    knots = result.cameras[1].depth_correction.relative + 2.5 * result.cameras[1].depth_correction.per_metre
    assert knots[:, 0].mean() < -0.003 < 0.003 < knots[:, -1].mean()
    assert not result.explains_more()  # as there was nothing to compare with


def test_poses_are_found_from_nothing():
    frame = corner_frame(color=True)
    truth = poses_of(frame)
    for camera in frame.cameras:
        camera.T_world_camera = numpy.eye(4)
    alignment = fuse_flow.CoarseAlignment()
    alignment.add_frame(frame)
    result = alignment.estimate()
    assert result.complete and result.placements == [fuse_flow.Placement.PLACED] * 4 and result.groups == [0] * 4
    for found, true in zip(result.T_world_camera, truth):
        assert apart(found, numpy.linalg.inv(truth[0]) @ true) < 0.05
