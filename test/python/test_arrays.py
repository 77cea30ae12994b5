"""Which arrays fit, that none is copied, and what is said of those that do not."""

import array
import ctypes
import gc
import sys
import weakref

import numpy
import pytest

import fuse_flow
from rigs import HEIGHT, WIDTH, intrinsics, paint, wall, wall_frame


def fused(view):
    return fuse_flow.FuseFlow().fuse(fuse_flow.RigFrame([fuse_flow.Camera(intrinsics())], [view])).array.tobytes()


def bumpy(dtype=numpy.uint16):
    v, u = numpy.mgrid[:HEIGHT, :WIDTH]
    return (1000 + 3 * u + 2 * v).astype(dtype)


def test_arrays_are_not_copied():
    depth, color = bumpy(), paint()
    view = fuse_flow.DepthView(depth, color)
    assert view.depth is depth and view.color is color
    before = fused(view)
    depth += 100
    assert fused(view) != before


def test_rows_may_be_any_number_of_bytes_apart():
    wide = numpy.zeros((HEIGHT, WIDTH + 24), numpy.uint16)
    wide[:, :WIDTH] = bumpy()
    colors = numpy.zeros((HEIGHT, WIDTH + 5, 3), numpy.uint8)
    colors[:, :WIDTH] = paint()
    assert fused(fuse_flow.DepthView(wide[:, :WIDTH], colors[:, :WIDTH])) == fused(fuse_flow.DepthView(bumpy(), paint()))


def test_arrays_may_be_read_only():
    depth, color, confidence = bumpy(), paint(), numpy.ones((HEIGHT, WIDTH), numpy.float32)
    for image in (depth, color, confidence):
        image.flags.writeable = False
    sure = numpy.ones((HEIGHT, WIDTH), numpy.float32)
    assert fused(fuse_flow.DepthView(depth, color, confidence)) == fused(fuse_flow.DepthView(bumpy(), paint(), sure))


def test_whatever_numpy_sees_without_a_copy_fits():
    depth = bumpy()
    memory = memoryview(array.array("H", depth.ravel().tolist())).cast("B").cast("H", (HEIGHT, WIDTH))
    assert fused(fuse_flow.DepthView(memory)) == fused(fuse_flow.DepthView(depth))


def test_confidence_below_half_is_dropped():
    confidence = numpy.ones((HEIGHT, WIDTH), numpy.float32)
    confidence[:, : WIDTH // 2] = 0.1
    cloud = fuse_flow.FuseFlow().fuse(
        fuse_flow.RigFrame([fuse_flow.Camera(intrinsics())], [fuse_flow.DepthView(wall(), confidence=confidence)]))
    assert len(cloud) > 500 and cloud.points[:, 0].min() > -0.01


@pytest.mark.parametrize("image, message", [
    ({"depth": numpy.ones((HEIGHT, WIDTH))}, r"depth is float64 of shape \(120, 160\), must be uint16 .* or float32 \(metres\)"),
    ({"depth": numpy.ones((HEIGHT, WIDTH), numpy.int16)}, "depth is int16"),
    ({"depth": numpy.ones((HEIGHT, WIDTH), ">u2")}, "depth is >u2"),
    ({"depth": numpy.ones((HEIGHT, WIDTH, 1), numpy.uint16)}, r"of shape \(120, 160, 1\), must be .* of shape \(height, width\)"),
    ({"depth": numpy.ones(HEIGHT * WIDTH, numpy.uint16)}, "of shape"),
    ({"depth": [[1, 2], [3, 4]]}, "depth is int64"),
    ({"depth": "depth.png"}, "depth is <U9"),
    ({"depth": numpy.ones((0, WIDTH), numpy.uint16)}, "an image without pixels"),
    ({"depth": bumpy()[:, ::-1]}, r"depth has strides .* numpy.ascontiguousarray\(depth\) makes a copy that fits"),
    ({"depth": bumpy()[::-1]}, "depth has strides"),
    ({"depth": numpy.asfortranarray(bumpy())}, "depth has strides"),
    ({"depth": bumpy()[:, ::2]}, "depth has strides"),
    ({"depth": numpy.broadcast_to(numpy.uint16(1000), (HEIGHT, WIDTH))}, "depth has strides"),
    ({"depth": numpy.frombuffer(b"\0" * (2 * HEIGHT * WIDTH + 1), numpy.uint8)[1:].view(numpy.uint16).reshape(HEIGHT, WIDTH)},
     "not aligned to 2 bytes"),
    ({"depth": wall(), "color": numpy.zeros((HEIGHT, WIDTH, 4), numpy.uint8)},
     r"color is uint8 of shape \(120, 160, 4\), must be uint8 of shape \(height, width, 3\): red, green, blue"),
    ({"depth": wall(), "color": numpy.zeros((HEIGHT, WIDTH, 3), numpy.float32)}, "color is float32"),
    ({"depth": wall(), "color": paint()[:, :, ::-1]}, "color has strides"),
    ({"depth": wall(), "confidence": numpy.ones((HEIGHT, WIDTH))}, "confidence is float64 .* must be float32"),
])
def test_an_array_that_does_not_fit_is_a_value_error_that_says_what_would(image, message):
    with pytest.raises(ValueError, match=message):
        fuse_flow.DepthView(**image)


def test_an_attribute_that_is_refused_stays_what_it_was():
    view = fuse_flow.DepthView(wall())
    with pytest.raises(ValueError):
        view.depth = wall().astype(float)
    assert view.depth.dtype == numpy.uint16


class OnGpu:
    """A tensor, as its library describes it. Nobody reads its memory here."""

    def __init__(self, typestr="<u2", shape=(HEIGHT, WIDTH), strides=None):
        self.__cuda_array_interface__ = {"version": 3, "typestr": typestr, "shape": shape, "strides": strides, "data": (4096, True), "stream": 1}


def test_a_tensor_of_a_gpu_is_for_a_fusion_on_a_gpu():
    view = fuse_flow.DepthView(OnGpu())
    frame = fuse_flow.RigFrame([fuse_flow.Camera(intrinsics())], [view])
    for use in (fuse_flow.FuseFlow().fuse, fuse_flow.ExtrinsicEstimation().add_frame, lambda frame: frame.check()):
        with pytest.raises(ValueError, match=r"depth is in the memory of a GPU: FuseFlow\(device='gpu'\) reads it there"):
            use(frame)


def test_a_tensor_of_a_gpu_that_does_not_fit_is_refused_as_an_array_is():
    with pytest.raises(ValueError, match="depth is float64"):
        fuse_flow.DepthView(OnGpu("<f8"))
    with pytest.raises(ValueError, match="depth has strides"):
        fuse_flow.DepthView(OnGpu(strides=(2, 2 * HEIGHT)))


def test_a_device_that_is_not_there_is_named():
    with pytest.raises(ValueError, match="device is 'tpu', must be 'cpu' or 'gpu'"):
        fuse_flow.FuseFlow("tpu")
    with pytest.raises(ValueError, match=r"FuseFlow\(device='gpu'\), and this one is on the CPU"):
        fuse_flow.FuseFlow().fuse_on_device(wall_frame())
    try:
        fuse_flow.FuseFlow("gpu")
    except RuntimeError as error:
        assert "device='gpu': " in str(error)


def test_an_array_that_changes_its_shape_is_looked_at_again():
    depth = wall()
    frame = fuse_flow.RigFrame([fuse_flow.Camera(intrinsics())], [fuse_flow.DepthView(depth)])
    depth.shape = (WIDTH, HEIGHT)
    with pytest.raises(ValueError, match="depth image is 120x160, its camera is 160x120"):
        fuse_flow.FuseFlow().fuse(frame)


def test_images_of_another_size_than_their_camera_are_named():
    frame = wall_frame()
    frame.views[1] = fuse_flow.DepthView(wall()[:60])
    with pytest.raises(ValueError, match=r"fuse_flow.DepthView of camera 'camera 1': depth image is 160x60, its camera is 160x120"):
        fuse_flow.FuseFlow().fuse(frame)
    with pytest.raises(ValueError, match="camera 1"):
        frame.check()


def test_a_frame_with_as_many_views_as_cameras_is_asked_for():
    frame = wall_frame()
    frame.views.append(None)
    with pytest.raises(ValueError, match="has 2 cameras but 3 views"):
        fuse_flow.FuseFlow().fuse(frame)
    frame.views = [wall(), wall()]
    with pytest.raises(TypeError, match=r"views\[0\] is ndarray, must be a DepthView, or None"):
        fuse_flow.FuseFlow().fuse(frame)
    with pytest.raises(TypeError, match=r"cameras\[0\] is str, must be a Camera"):
        fuse_flow.RigFrame(["left"], [None])


def test_a_frame_keeps_its_arrays_alive():
    depth = wall()
    count = sys.getrefcount(depth)
    frame = fuse_flow.RigFrame([fuse_flow.Camera(intrinsics())], [fuse_flow.DepthView(depth)])
    assert sys.getrefcount(depth) == count + 1
    del depth
    assert len(fuse_flow.FuseFlow().fuse(frame)) > 0


def test_arrays_of_a_cloud_keep_its_memory():
    points = fuse_flow.FuseFlow().fuse(wall_frame()).points
    gc.collect()
    fuse_flow.FuseFlow().fuse(wall_frame())
    assert numpy.abs(points[:, 2] - 1).max() < 1e-5


def test_a_later_frame_changes_no_earlier_cloud():
    fusion = fuse_flow.FuseFlow()
    first = fusion.fuse(wall_frame())
    before = first.array.tobytes()
    frame = wall_frame()
    for view in frame.views:
        view.depth = wall(2000)
    for _ in range(4):
        fusion.fuse(frame)
    assert first.array.tobytes() == before


def test_cycles_through_frames_and_views_are_collected():
    class Depth(numpy.ndarray):
        pass

    gc.collect()
    frame = wall_frame()
    depth = wall().view(Depth)
    frame.views[0] = fuse_flow.DepthView(depth)
    depth.frame = frame
    frame.cameras.append(frame.cameras)
    gone = weakref.ref(depth)
    del depth, frame
    gc.collect()
    assert gone() is None


class ByDlpack:
    """A tensor that says it is on GPU 0; its memory is numpy's, and nobody reads it here."""

    def __init__(self, array):
        self.array, self.streams = array, []

    def __dlpack_device__(self):
        return (2, 0)

    def __dlpack__(self, stream=None):
        self.streams.append(stream)
        return self.array.__dlpack__()


@pytest.mark.skipif(not hasattr(numpy.ndarray, "__dlpack__"), reason="needs numpy 1.22")
def test_a_tensor_by_dlpack_is_looked_at_without_waiting_and_let_go():
    depth = wall().astype(numpy.float32)
    count = sys.getrefcount(depth)
    tensor = ByDlpack(depth)
    view = fuse_flow.DepthView(tensor)
    assert view.depth is tensor and tensor.streams == [-1] and not view.missing
    with pytest.raises(ValueError, match=r"depth is float32 of shape \(160, 120, 1\)"):
        view.depth = ByDlpack(depth.reshape(WIDTH, HEIGHT, 1))
    with pytest.raises(ValueError, match="depth is float64"):
        view.depth = ByDlpack(depth.astype(float))
    assert view.depth is tensor
    del view, tensor
    gc.collect()
    assert sys.getrefcount(depth) == count


@pytest.mark.skipif(not hasattr(numpy.ndarray, "__dlpack__"), reason="needs numpy 1.22")
def test_a_library_that_does_not_know_nobody_is_asked_again():
    class LikeJax(ByDlpack):
        def __dlpack__(self, stream=None):
            if stream == -1:
                raise RuntimeError("CUDA_ERROR_INVALID_HANDLE")
            return super().__dlpack__(stream)

    tensor = LikeJax(wall().astype(numpy.float32))
    assert fuse_flow.DepthView(tensor).depth is tensor and tensor.streams == [None]

    class Broken(ByDlpack):
        def __dlpack__(self, stream=None):
            raise BufferError("needs grad")

    with pytest.raises(BufferError, match="needs grad"):
        fuse_flow.DepthView(Broken(wall()))


class _Tensor(ctypes.Structure):
    """DLPack's DLTensor."""

    _fields_ = [("data", ctypes.c_void_p), ("device", ctypes.c_int32 * 2), ("ndim", ctypes.c_int32), ("code", ctypes.c_uint8), ("bits", ctypes.c_uint8),
                ("lanes", ctypes.c_uint16), ("shape", ctypes.c_void_p), ("strides", ctypes.c_void_p), ("byte_offset", ctypes.c_uint64)]  # fmt: skip


_Describe = ctypes.PYFUNCTYPE(ctypes.c_int, ctypes.py_object, ctypes.POINTER(_Tensor))
_ManagedOf = ctypes.PYFUNCTYPE(ctypes.c_int, ctypes.py_object, ctypes.POINTER(ctypes.c_void_p))
_CurrentStream = ctypes.PYFUNCTYPE(ctypes.c_int, ctypes.c_int, ctypes.c_int32, ctypes.POINTER(ctypes.c_void_p))


class _Exchange(ctypes.Structure):
    """DLPack's DLPackExchangeAPI, version 1.3."""

    _fields_ = [("major", ctypes.c_uint32), ("minor", ctypes.c_uint32), ("older", ctypes.c_void_p), ("allocate", ctypes.c_void_p),
                ("managed_of", _ManagedOf), ("object_of", ctypes.c_void_p), ("describe", _Describe), ("current_stream", _CurrentStream)]  # fmt: skip


def exchanging(shape, strides=None, code=2, bits=32, major=1, older=None, complete=True):
    """A tensor on a GPU whose class has the functions of DLPack 1.3; how often it was described is counted."""

    class Tensor:
        described = 0
        shape_and_strides = (ctypes.c_int64 * 6)(*shape, *[0] * (3 - len(shape)), *(strides or [0] * len(shape)))

        def __dlpack_device__(self):
            raise AssertionError("asked by Python")

        def __dlpack__(self, stream=None):
            raise AssertionError("asked by Python")

    @_Describe
    def describe(tensor, out):
        Tensor.described += 1
        places = ctypes.addressof(Tensor.shape_and_strides)
        out[0] = _Tensor(4096, (2, 0), len(shape), code, bits, 1, places, places + 24 if strides else None, 0)
        return 0

    @_ManagedOf
    def managed_of(tensor, out):
        raise AssertionError("only a GPU reads it")

    @_CurrentStream
    def current_stream(kind, device, out):
        out[0] = None
        return 0

    Tensor.table = _Exchange(major, 3, older, None, managed_of, None, describe if complete else _Describe(), current_stream)
    new = ctypes.pythonapi.PyCapsule_New
    new.restype, new.argtypes = ctypes.py_object, [ctypes.c_void_p, ctypes.c_char_p, ctypes.c_void_p]
    Tensor.__dlpack_c_exchange_api__ = new(ctypes.addressof(Tensor.table), b"dlpack_exchange_api", None)
    return Tensor()


def test_a_library_with_functions_for_c_is_not_asked_by_python():
    depth, color = exchanging((HEIGHT, WIDTH)), exchanging((HEIGHT, WIDTH, 3), code=1, bits=8)
    view = fuse_flow.DepthView(depth, color)
    assert view.depth is depth and not view.missing
    assert depth.described > 0 and color.described > 0
    with pytest.raises(ValueError, match="GPU"):
        fused(view)


def test_what_does_not_fit_is_said_of_tensors_that_functions_for_c_describe():
    with pytest.raises(ValueError, match="depth is float64 of shape"):
        fuse_flow.DepthView(exchanging((HEIGHT, WIDTH), bits=64))
    with pytest.raises(ValueError, match="follow each other"):
        fuse_flow.DepthView(exchanging((HEIGHT, WIDTH), strides=(2 * WIDTH, 2, 0)))
    fuse_flow.DepthView(exchanging((HEIGHT, WIDTH), strides=(2 * WIDTH, 1, 0)))


def test_functions_of_another_version_are_not_called():
    older = exchanging((HEIGHT, WIDTH))
    newer = exchanging((HEIGHT, WIDTH), major=2, older=ctypes.addressof(older.table))
    fuse_flow.DepthView(newer)
    assert older.described > 0 and newer.described == 0
    for tensor in (exchanging((HEIGHT, WIDTH), major=2), exchanging((HEIGHT, WIDTH), complete=False)):
        with pytest.raises(AssertionError, match="asked by Python"):
            fuse_flow.DepthView(tensor)
