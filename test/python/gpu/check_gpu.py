"""Tensors of a GPU in, clouds on the GPU out. For a machine that has one: pytest check_gpu.py; what is not installed there is skipped."""

import pathlib
import sys
import time

import numpy
import pytest

import fuse_flow

sys.path.insert(0, str(pathlib.Path(__file__).parents[1]))
from rigs import HEIGHT, WIDTH, intrinsics, rough_frame, wall  # noqa: E402

torch = pytest.importorskip("torch")


def cupy():
    return pytest.importorskip("cupy")


def to_torch(image):
    """uint16 by way of int16, which every version of PyTorch copies."""
    if image.dtype == numpy.uint16:
        return torch.from_numpy(image.view(numpy.int16)).cuda().view(torch.uint16)
    return torch.from_numpy(image).cuda()


def on_gpu(frame, convert):
    views = [fuse_flow.DepthView(convert(view.depth), convert(view.color)) for view in frame.views]
    return fuse_flow.RigFrame(frame.cameras, views, frame.stamp)


def test_tensors_give_the_bytes_that_arrays_give():
    frame = rough_frame(cameras=4)
    fusion = fuse_flow.FuseFlow("gpu")
    expected = fusion.fuse(frame).array.tobytes()
    assert len(expected) > 32000
    assert fusion.fuse(on_gpu(frame, to_torch)).array.tobytes() == expected
    assert fusion.fuse(on_gpu(frame, cupy().asarray)).array.tobytes() == expected


def test_the_gpu_has_the_points_of_the_cpu():
    frame = rough_frame(cameras=4)
    gpu, cpu = fuse_flow.FuseFlow("gpu").fuse(frame), fuse_flow.FuseFlow("cpu").fuse(frame)
    assert abs(len(gpu) - len(cpu)) <= 0.001 * len(cpu)


def test_metres_as_float_and_confidence_are_read_on_the_gpu():
    depth, confidence = wall(1.0, numpy.float32), numpy.ones((HEIGHT, WIDTH), numpy.float32)
    confidence[:, : WIDTH // 2] = 0.1
    view = fuse_flow.DepthView(to_torch(depth), confidence=to_torch(confidence))
    points = fuse_flow.FuseFlow("gpu").fuse(fuse_flow.RigFrame([fuse_flow.Camera(intrinsics())], [view])).points
    assert len(points) > 500 and points[:, 0].min() > -0.01 and numpy.abs(points[:, 2] - 1).max() < 1e-5


def test_rows_of_a_tensor_may_have_padding():
    frame = rough_frame()
    expected = fuse_flow.FuseFlow("gpu").fuse(frame).array.tobytes()

    def padded(image):
        wide = numpy.zeros((image.shape[0], image.shape[1] + 32) + image.shape[2:], image.dtype)
        wide[:, : image.shape[1]] = image
        return to_torch(wide)[:, : image.shape[1]]

    assert fuse_flow.FuseFlow("gpu").fuse(on_gpu(frame, padded)).array.tobytes() == expected


def test_clouds_on_the_gpu_are_those_on_the_host():
    frame = rough_frame()
    fusion = fuse_flow.FuseFlow("gpu", normals=True, camera_mask=True)
    host = fusion.fuse(frame)
    cloud = fusion.fuse_on_device(on_gpu(frame, to_torch))
    assert len(cloud) == len(host)
    for name in ("points", "confidence", "view_count", "normals", "camera_mask"):
        there = torch.from_dlpack(getattr(cloud, name)).cpu().numpy()
        assert there.tobytes() == numpy.ascontiguousarray(getattr(host, name)).tobytes(), name
    bgra = torch.from_dlpack(cloud.bgra).cpu().numpy()
    assert numpy.array_equal(bgra[:, 2::-1], host.colors)
    assert numpy.array_equal(cupy().asarray(cloud.points).get(), host.points)
    assert numpy.array_equal(cupy().from_dlpack(cloud.points).get(), host.points)


def test_arrays_of_jax_give_the_bytes_that_arrays_give():
    jax = pytest.importorskip("jax")
    if jax.default_backend() != "gpu":
        pytest.skip("jax has no GPU here")
    frame = rough_frame()
    fusion = fuse_flow.FuseFlow("gpu")
    expected = fusion.fuse(frame).array.tobytes()
    assert fusion.fuse(on_gpu(frame, jax.numpy.asarray)).array.tobytes() == expected
    cloud, host = fusion.fuse_on_device(on_gpu(frame, jax.numpy.asarray)), fusion.fuse(frame)
    words = numpy.asarray(jax.dlpack.from_dlpack(cloud.words))
    assert numpy.array_equal(words[:, :3], host.points)
    assert numpy.array_equal(words[:, cloud.columns["confidence"]], host.confidence)
    assert numpy.array_equal(words.view(numpy.int32)[:, cloud.columns["view_count"]], host.view_count)


def test_whole_points_have_all_fields():
    frame = rough_frame()
    cloud = fuse_flow.FuseFlow("gpu", normals=True, camera_mask=True).fuse_on_device(frame)
    words = torch.from_dlpack(cloud.words)
    assert words.is_contiguous() and len(words) == len(cloud)
    for name, width in (("points", 3), ("confidence", 0), ("normals", 3)):
        column = cloud.columns[name]
        field = words[:, column : column + width] if width else words[:, column]
        assert torch.equal(field.nan_to_num(), torch.from_dlpack(getattr(cloud, name)).nan_to_num()), name
    for name, width in (("view_count", 0), ("camera_mask", 2)):
        column = cloud.columns[name]
        field = words.view(torch.int32)[:, column : column + width] if width else words.view(torch.int32)[:, column]
        assert torch.equal(field, torch.from_dlpack(getattr(cloud, name))), name
    assert "normals" not in fuse_flow.FuseFlow("gpu").fuse_on_device(frame).columns


def test_tensors_are_described_with_and_without_functions_for_c():
    frame = rough_frame()
    fusion = fuse_flow.FuseFlow("gpu")
    expected = fusion.fuse(frame).array.tobytes()

    class OnlyMethods(torch.Tensor):
        __dlpack_c_exchange_api__ = None

    assert fusion.fuse(on_gpu(frame, lambda image: to_torch(image).as_subclass(OnlyMethods))).array.tobytes() == expected


def test_memory_that_is_let_go_meanwhile_is_kept_for_the_frame():
    frame = rough_frame()
    fusion = fuse_flow.FuseFlow("gpu")
    expected = fusion.fuse(frame).array.tobytes()
    tensors = on_gpu(frame, to_torch)
    assert fusion.fuse(tensors).array.tobytes() == expected
    for view in tensors.views:  # what the last frame kept does not keep the tensors of this one
        view.depth.set_(torch.zeros_like(view.depth))
    assert len(fusion.fuse(tensors)) == 0


def test_work_on_the_tensors_own_stream_is_waited_for():
    frame = rough_frame()
    fusion = fuse_flow.FuseFlow("gpu")
    expected = fusion.fuse(frame).array.tobytes()
    late = on_gpu(frame, to_torch)
    source = [view.depth.clone() for view in late.views]
    for view in late.views:
        view.depth.view(torch.int16).zero_()
    torch.cuda.synchronize()
    with torch.cuda.stream(torch.cuda.Stream()):
        torch.cuda._sleep(200_000_000)
        for view, depth in zip(late.views, source):
            view.depth.view(torch.int16).copy_(depth.view(torch.int16))
        assert fusion.fuse(late).array.tobytes() == expected


def test_a_cloud_that_is_still_read_is_not_overwritten():
    first, second = rough_frame(1), rough_frame(2)
    fusion = fuse_flow.FuseFlow("gpu")
    expected = fusion.fuse(first).points.copy()
    points = torch.from_dlpack(fusion.fuse_on_device(first).points)
    for _ in range(4):
        fusion.fuse_on_device(second)
    assert numpy.array_equal(points.cpu().numpy(), expected)


def test_thousands_of_frames_leave_no_memory():
    frame = on_gpu(rough_frame(), to_torch)
    fusion = fuse_flow.FuseFlow("gpu")
    for _ in range(100):
        torch.from_dlpack(fusion.fuse_on_device(frame).points)
    before = torch.cuda.mem_get_info()[0]
    for _ in range(3000):
        torch.from_dlpack(fusion.fuse_on_device(frame).points)
    assert before - torch.cuda.mem_get_info()[0] < 4 << 20


def test_tensors_that_do_not_fit_are_refused():
    with pytest.raises(ValueError, match="depth is float64"):
        fuse_flow.DepthView(torch.zeros((HEIGHT, WIDTH), dtype=torch.float64, device="cuda"))
    with pytest.raises(ValueError, match="GPU"):
        fuse_flow.FuseFlow("cpu").fuse(on_gpu(rough_frame(), to_torch))


def test_what_python_costs_is_printed():
    random = numpy.random.default_rng(1)
    K = fuse_flow.Intrinsics(640, 480, 525, 525, 319.5, 239.5)
    cameras, views = [], []
    for i in range(8):
        pose = numpy.eye(4)
        pose[0, 3] = 0.1 * i
        cameras.append(fuse_flow.Camera(K, pose))
        depth = (1500 + random.integers(-3, 4, (480, 640))).astype(numpy.uint16)
        views.append(fuse_flow.DepthView(to_torch(depth), to_torch(random.integers(0, 256, (480, 640, 3)).astype(numpy.uint8))))
    fusion = fuse_flow.FuseFlow("gpu")
    frame = fuse_flow.RigFrame(cameras, views)
    whole, library = [], []
    for _ in range(300):
        begin = time.perf_counter()
        torch.from_dlpack(fusion.fuse_on_device(frame).points)
        whole.append(1e3 * (time.perf_counter() - begin))
        library.append(fusion.statistics.total_ms)
    print(f"\n8 x 640x480 on the GPU: {numpy.median(whole):.3f} ms in Python, {numpy.median(library):.3f} ms of them in the library")
