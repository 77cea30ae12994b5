"""The four filters on arrays, and the measures of quality, of geometry that is known by hand."""

import numpy
import pytest

import fuse_flow
from rigs import FOCAL, HEIGHT, WIDTH, at, intrinsics, wall, wall_frame


def camera(**values):
    return fuse_flow.Camera(intrinsics(), **values)


def test_back_projection_is_the_pinhole_equation():
    points = fuse_flow.depth_backprojection(fuse_flow.DepthView(wall(2000)), camera(T_world_camera=at(x=1)))
    assert points.shape == (HEIGHT, WIDTH, 3) and points.dtype == numpy.float32
    v, u = numpy.mgrid[:HEIGHT, :WIDTH]
    expected = numpy.stack([2 * (u - (WIDTH - 1) / 2) / FOCAL + 1, 2 * (v - (HEIGHT - 1) / 2) / FOCAL, numpy.full_like(u, 2, float)], axis=-1)
    assert numpy.abs(points - expected).max() < 1e-5


def test_pixels_without_a_measurement_have_no_point():
    depth = wall()
    depth[10, 20] = 0
    points = fuse_flow.depth_backprojection(fuse_flow.DepthView(depth), camera())
    assert numpy.isnan(points[10, 20]).all() and numpy.isfinite(points).all(axis=2).sum() == depth.size - 1


def test_confidence_is_high_on_a_plane_and_low_beside_an_edge():
    depth = wall()
    depth[:, WIDTH // 2 :] = 2000
    C = fuse_flow.confidence_estimation(fuse_flow.DepthView(depth), camera())
    assert C.shape == (HEIGHT, WIDTH)
    assert C[20:-20, 20 : WIDTH // 2 - 20].min() > 0.95
    assert C[20:-20, WIDTH // 2].max() < fuse_flow.ConfidenceParameters().threshold
    depth[5, 5] = 0
    assert fuse_flow.confidence_estimation(fuse_flow.DepthView(depth), camera())[5, 5] == 0


def test_points_on_the_wall_are_consistent_and_points_before_it_are_not():
    points = numpy.array([[0, 0, 1.0], [0.1, 0.1, 1.0], [0, 0, 0.5], [0, 0, numpy.nan]])
    V, views = fuse_flow.multi_view_consistency(points, wall_frame())
    assert V[:2].min() > 0.99 and V[2] < 0.01 and (views[:3] == 2).all()
    V, views = fuse_flow.multi_view_consistency(points, wall_frame(), source_camera=0)
    assert (views[:3] == 1).all()


def test_points_of_one_cell_become_one_point():
    grid = numpy.array([[0.001, 0.002, 1.001], [0.003, 0.002, 1.003]])
    parameters = fuse_flow.AggregationParameters(cell_size=0.01, min_cell_size=0.01)
    cloud = fuse_flow.adaptive_hash_fusion(grid, cameras=[0, 1], colors=numpy.array([[10, 0, 0], [30, 0, 0]], numpy.uint8), parameters=parameters)
    assert len(cloud) == 1
    assert cloud.points[0] == pytest.approx([0.002, 0.002, 1.002], abs=1e-6)
    assert cloud.colors[0, 0] == 20 and cloud.view_count[0] == 2


@pytest.mark.parametrize("points", [numpy.zeros((5, 2)), numpy.zeros(3), numpy.zeros((5, 3), int), "points"])
def test_points_that_are_none_are_refused(points):
    with pytest.raises(ValueError, match=r"points is .* must be float32 or float64 of shape \(N, 3\)"):
        fuse_flow.adaptive_hash_fusion(points)


def test_what_belongs_to_points_has_their_number():
    points = numpy.zeros((4, 3))
    with pytest.raises(ValueError, match=r"cameras is .*, must be integers of shape \(4,\)"):
        fuse_flow.adaptive_hash_fusion(points, cameras=[0, 1])
    with pytest.raises(ValueError, match=r"confidence is int64"):
        fuse_flow.adaptive_hash_fusion(points, confidence=[1, 1, 1, 1])
    with pytest.raises(ValueError, match=r"colors must be uint8 of shape \(4, 3\)"):
        fuse_flow.adaptive_hash_fusion(points, colors=numpy.zeros((4, 4), numpy.uint8))
    with pytest.raises(ValueError, match="4 points but 3 normals"):
        fuse_flow.multi_view_consistency(points, wall_frame(), normals=numpy.zeros((3, 3)))


def test_a_view_without_depth_has_no_steps():
    with pytest.raises(ValueError, match="has no depth"):
        fuse_flow.depth_backprojection(fuse_flow.DepthView(), camera())


def test_a_cloud_on_the_wall_has_no_reprojection_error_and_covers_it():
    frame = wall_frame()
    cloud = fuse_flow.FuseFlow().fuse(frame)
    quality = fuse_flow.reprojection_quality(cloud, frame)
    assert quality.points == len(cloud) and quality.violating_points == 0
    assert quality.error < 1e-5 and quality.coverage > 0.95
    behind = fuse_flow.reprojection_quality(cloud.points + numpy.float32([0, 0, 0.01]), frame)
    assert behind.error == pytest.approx(0.01, abs=1e-4)


def test_a_flat_cloud_has_no_noise_and_two_sheets_are_found():
    frame = wall_frame()
    cloud = fuse_flow.FuseFlow().fuse(frame)
    flat = fuse_flow.surface_quality(cloud, frame)
    assert flat.noise < 1e-5 and flat.double_surfaces == 0 and flat.coverage > 0.95
    sheets = numpy.concatenate([cloud.points, cloud.points + numpy.float32([0.002, 0, 0.02])])
    assert fuse_flow.surface_quality(sheets, frame).double_surfaces > 0.9
    total = fuse_flow.SurfaceQuality()
    total += flat
    total += flat
    assert total.points == 2 * flat.points


def test_what_does_not_move_does_not_flicker():
    frame = wall_frame()
    cloud = fuse_flow.FuseFlow().fuse(frame)
    assert fuse_flow.temporal_flicker(cloud, frame, cloud, frame).mean < 1e-6
    with pytest.raises(ValueError):
        fuse_flow.temporal_flicker(cloud, frame, cloud, wall_frame(1))
