"""A server and a client of its stream, in one program."""

import os
import subprocess
import sys
import textwrap
import threading
import time
import urllib.error
import urllib.request

import numpy
import pytest

import fuse_flow
from endings import assert_ended_cleanly
from other_threads import most_counted_during
from rigs import wall_frame

pytestmark = pytest.mark.skipif(not hasattr(fuse_flow, "StreamServer"), reason="the module was built without streams")


def receive(server, client, cloud, number=None, **fields):
    for _ in range(100):
        server.publish(cloud, number, **fields)
        received = client.pull(0.1)
        if received is not None:
            return received
    raise AssertionError(client.error)


def test_a_cloud_arrives_as_it_was_to_half_a_step():
    cloud = fuse_flow.FuseFlow(normals=True).fuse(wall_frame())
    with fuse_flow.StreamServer(0, step=0.002) as server, fuse_flow.StreamClient(server.link) as client:
        server.describe("a wall", wall_frame().cameras)
        received = receive(server, client, cloud, 7)
        assert len(received) == len(cloud) == received.points_of_frame and received.number == 7 and received.step == 0.002
        low, high = received.points.min(axis=0), received.points.max(axis=0)
        assert numpy.abs(low - cloud.points.min(axis=0)).max() < 0.0011 and numpy.abs(high - cloud.points.max(axis=0)).max() < 0.0011
        assert (received.colors == (200, 120, 40)).all()
        assert received.confidence.max() <= 1 and received.view_count.max() == 2 and received.normals.shape == received.points.shape
        assert client.connected and server.watched


def test_arrays_of_a_received_cloud_stay():
    cloud = fuse_flow.FuseFlow().fuse(wall_frame())
    with fuse_flow.StreamServer(0) as server:
        with fuse_flow.StreamClient(server.link) as client:
            points = receive(server, client, cloud).points
            receive(server, client, cloud)
    assert numpy.abs(points[:, 2] - 1).max() < 0.001


def test_a_pull_ends_with_its_time_and_a_closed_end_says_so():
    server = fuse_flow.StreamServer(0)
    client = fuse_flow.StreamClient(server.link)
    begin = time.monotonic()
    assert client.pull(0.2) is None and time.monotonic() - begin < 20
    client.close()
    server.close()
    with pytest.raises(RuntimeError, match="StreamClient is closed"):
        client.pull(0)
    with pytest.raises(RuntimeError, match="StreamServer is closed"):
        server.link


def test_wrong_options_are_refused():
    with pytest.raises(ValueError, match="token"):
        fuse_flow.StreamServer(0, address="0.0.0.0")
    with pytest.raises(ValueError):
        fuse_flow.StreamServer(0, step=-1)
    with pytest.raises(ValueError):
        fuse_flow.StreamClient("ftp://127.0.0.1/")


def points_in_a_row(count=500):
    """Points 1 cm apart, of which each has its own colour, confidence, normal and cameras."""
    i = numpy.arange(count)
    points = numpy.stack([0.01 * i, numpy.full(count, -0.5), numpy.full(count, 2.0)], axis=1).astype(numpy.float32)
    colors = numpy.stack([i % 256, 255 - i % 256, (7 * i) % 256], axis=1).astype(numpy.uint8)
    normals = numpy.where(i[:, None] % 2 == 0, (0.0, 0.0, -1.0), (1.0, 0.0, 0.0))
    return points, {"colors": colors, "confidence": (i % 256) / 255, "view_count": i % 5 + 1, "normals": normals,
                    "camera_mask": numpy.stack([i, i + 1], axis=1).astype(numpy.uint32)}


def check_row(received, points, fields):
    order = numpy.argsort(received.points[:, 0])
    assert numpy.abs(received.points[order] - points).max() < 0.00051
    assert numpy.array_equal(received.colors[order], fields["colors"])
    assert numpy.abs(received.confidence[order] - fields["confidence"]).max() < 1e-6
    assert numpy.array_equal(received.view_count[order], fields["view_count"])
    assert numpy.abs(received.normals[order] - fields["normals"]).max() < 0.02
    assert numpy.array_equal(received.camera_mask[order], fields["camera_mask"])


def test_arrays_arrive_each_point_with_what_is_its_own():
    points, fields = points_in_a_row()
    with fuse_flow.StreamServer(0, encoding=fuse_flow.StreamEncoding(camera_mask=True)) as server:
        with fuse_flow.StreamClient(server.link) as client:
            check_row(receive(server, client, points, **fields), points, fields)
            mirrored = dict(fields, colors=fields["colors"][:, ::-1])  # strides that run backwards
            check_row(receive(server, client, points.astype(float), **mirrored), points, mirrored)
            alone = receive(server, client, points[::2])
            assert len(alone) == 250 and numpy.abs(numpy.sort(alone.points[:, 0]) - points[::2, 0]).max() < 0.00051
            assert alone.colors is None and alone.confidence is None and alone.normals is None
            assert len(receive(server, client, numpy.empty((0, 3), numpy.float32))) == 0


def test_arrays_that_do_not_fit_are_refused_and_it_is_said_what_would():
    points, fields = points_in_a_row()
    with fuse_flow.StreamServer(0) as server:
        for wrong, right in [({"colors": fields["colors"] / 255}, r"colors is float64 .* must be uint8 of shape \(500, 3\)"),
                             ({"colors": fields["colors"][:7]}, r"colors is uint8 of shape \(7, 3\)"),
                             ({"confidence": fields["view_count"]}, "confidence is int64 .* must be floats"),
                             ({"view_count": fields["view_count"][:7]}, "view_count"),
                             ({"normals": fields["normals"][:7]}, "normals are 7, must be as many as the 500 points"),
                             ({"camera_mask": fields["camera_mask"].astype(float)}, "camera_mask is float64")]:
            with pytest.raises(ValueError, match=right):
                server.publish(points, **wrong)
        for wrong in (points[:, :2], points.astype(int), points.ravel()):
            with pytest.raises(ValueError, match=r"of shape \(N, 3\)"):
                server.publish(wrong)
        with pytest.raises(ValueError, match="has its own colors"):
            server.publish(fuse_flow.FuseFlow().fuse(wall_frame()), colors=fields["colors"])
        assert server.status.published == 0


def test_a_received_cloud_is_sent_on_with_its_number():
    points, fields = points_in_a_row()
    encoding = fuse_flow.StreamEncoding(camera_mask=True)
    with fuse_flow.StreamServer(0, encoding=encoding) as first, fuse_flow.StreamServer(0, encoding=encoding) as second:
        with fuse_flow.StreamClient(first.link) as between, fuse_flow.StreamClient(second.link) as client:
            received = receive(first, between, points, 41, captured=10**18, **fields)
            assert received.captured == 10**18 < received.encoded
            again = receive(second, client, received)
            check_row(again, points, fields)
            assert again.number == 41 and again.captured == 10**18 and again.encoded >= received.encoded


def test_frames_are_counted():
    with fuse_flow.StreamServer(0) as server, fuse_flow.StreamClient(server.link) as client:
        cloud = points_in_a_row()[0]
        first = receive(server, client, cloud, 9)
        assert first.number == 9 and receive(server, client, cloud).number > 9
        assert server.status.clients[0].frames >= 1 and server.status.published >= 2
        assert client.status.frames >= 2 and client.status.error == ""


def test_a_client_learns_what_the_stream_is():
    with fuse_flow.StreamServer(0, step=0.002) as server, fuse_flow.StreamClient(server.link) as client:
        server.describe("a wall", wall_frame().cameras, frame="map")
        receive(server, client, points_in_a_row()[0])
        description = client.description
        assert (description.name, description.frame, description.step) == ("a wall", "map", 0.002)
        assert [camera.name for camera in description.cameras] == ["camera 0", "camera 1"]
        assert numpy.allclose(description.cameras[1].T_world_camera, wall_frame().cameras[1].T_world_camera)


def test_a_client_gets_as_little_as_it_wishes():
    cloud = points_in_a_row(40000)[0]
    with fuse_flow.StreamServer(0, encoding=fuse_flow.StreamEncoding(chunk_points=1024)) as server:
        with fuse_flow.StreamClient(server.link) as client:
            assert len(receive(server, client, cloud)) == 40000
            client.wish(region=((0, -1, 0), (100, 1, 3)))
            for _ in range(100):
                received = receive(server, client, cloud)
                if len(received) < 40000:
                    break
            assert 10000 <= len(received) < 20000 and received.points[:, 0].max() < 150
            with pytest.raises(ValueError):
                client.wish(step=0)


def test_images_are_encoded_only_for_who_wants_them():
    with fuse_flow.StreamServer(0) as server:
        cameras = wall_frame().cameras
        server.describe("a wall", cameras)
        intrinsics = cameras[0].intrinsics
        image = numpy.zeros((intrinsics.height, intrinsics.width, 3), numpy.uint8)
        server.publish_image(0, image, captured=10**18)
        server.publish_image(1, image[:, :, :])
        assert not server.image_wanted(0) and not server.image_wanted(7) and server.status.encoded_images == 0
        with pytest.raises(ValueError, match="camera 2: must be below 2"):
            server.publish_image(2, image)
        with pytest.raises(ValueError, match="must be of"):
            server.publish_image(0, image[1:])
        with pytest.raises(ValueError, match="uint8"):
            server.publish_image(0, image.astype(float))


def test_browsers_get_a_page_where_it_was_built():
    with fuse_flow.StreamServer(0) as server:
        if server.has_page:
            with urllib.request.urlopen(server.link) as page:
                assert b"<html" in page.read() and page.headers["Content-Type"].startswith("text/html")
        else:
            assert any("page" in line for line in server.warnings)
    with fuse_flow.StreamServer(0, page=False) as server:
        assert not server.has_page and server.warnings == []
        with pytest.raises(urllib.error.HTTPError):
            urllib.request.urlopen(server.link)


def test_a_file_gives_back_the_clouds_that_were_written(tmp_path):
    points, fields = points_in_a_row()
    cloud = fuse_flow.FuseFlow().fuse(wall_frame())
    encoding = fuse_flow.StreamEncoding(camera_mask=True)
    with fuse_flow.StreamWriter(tmp_path / "stream.ffs", name="walls", cameras=wall_frame().cameras, encoding=encoding) as writer:
        writer.write(points, captured=10**18, **fields)
        writer.write(cloud)
        writer.describe("a row", frame="map")
        writer.write(points, 17)
    with pytest.raises(RuntimeError, match="StreamWriter is closed"):
        writer.write(cloud)
    file = fuse_flow.StreamReader(tmp_path / "stream.ffs")
    assert len(file) == 3 and not file.cut_off and file.description.name == "walls" and file.time(0) == 10**18
    assert file.time(1) > 1.7e18  # when it was written, nanoseconds since 1970
    assert [len(received) for received in file] == [500, len(cloud), 500]
    assert (file.description.name, file.description.frame, file.description.step) == ("a row", "map", 0.001)
    row = file.read(0)
    check_row(row, points, fields)
    assert row.number == 0 and file.read(1).number == 1 and file.read(2).number == 17
    assert len(file.description.cameras) == 0  # of the frame that was read last
    file.read(0)
    assert len(file.description.cameras) == 2
    colors = row.colors
    del file, row
    assert colors.sum() == fields["colors"].sum()
    with fuse_flow.StreamWriter(tmp_path / "again.ffs", encoding=encoding) as writer:
        for received in fuse_flow.StreamReader(tmp_path / "stream.ffs"):
            writer.write(received)
    again = fuse_flow.StreamReader(tmp_path / "again.ffs")
    check_row(again.read(0), points, fields)
    assert again.read(2).number == 17 and again.time(0) == 10**18


def test_what_is_no_stream_file_is_said(tmp_path):
    with pytest.raises(ValueError, match="nowhere.ffs: cannot be read"):
        fuse_flow.StreamReader(tmp_path / "nowhere.ffs")
    (tmp_path / "text.ffs").write_text("once upon a time")
    with pytest.raises(ValueError, match="text.ffs: no stream file"):
        fuse_flow.StreamReader(str(tmp_path / "text.ffs"))
    with pytest.raises(OSError, match="cannot be written"):
        fuse_flow.StreamWriter(tmp_path / "no_folder" / "stream.ffs")
    with pytest.raises(ValueError, match="step"):
        fuse_flow.StreamWriter(tmp_path / "stream.ffs", step=0)
    with fuse_flow.StreamWriter(tmp_path / "stream.ffs") as writer:
        writer.write(points_in_a_row()[0])
        writer.write(points_in_a_row()[0])
    whole = (tmp_path / "stream.ffs").read_bytes()
    (tmp_path / "stream.ffs").write_bytes(whole[:-5])
    cut = fuse_flow.StreamReader(tmp_path / "stream.ffs")
    assert cut.cut_off and len(cut) == 1 == len(list(cut))
    with pytest.raises(IndexError):
        cut.read(1)
    (tmp_path / "stream.ffs").write_bytes(whole[:-50] + bytes(50))
    with pytest.raises(ValueError, match="stream.ffs: frame 1 is damaged"):
        fuse_flow.StreamReader(tmp_path / "stream.ffs").read(1)


def test_other_threads_run_while_a_cloud_is_encoded(tmp_path):
    cloud = points_in_a_row(1000000)[0]
    with fuse_flow.StreamWriter(tmp_path / "stream.ffs", encoding=fuse_flow.StreamEncoding(threads=1)) as writer:
        assert most_counted_during(lambda: writer.write(cloud), 3) > 10


def test_thousands_of_clouds_leave_no_memory(tmp_path):
    from test_lifetime import resident_kilobytes

    points, fields = points_in_a_row(2000)

    def run(count):
        kept = None
        with fuse_flow.StreamWriter(tmp_path / "stream.ffs", encoding=fuse_flow.StreamEncoding(threads=1)) as writer:
            for _ in range(count):
                writer.write(points, **fields)
        for received in fuse_flow.StreamReader(tmp_path / "stream.ffs"):
            kept = (received.points, received.colors, received.camera_mask)
        return kept

    run(50)
    before = resident_kilobytes()
    run(1000)
    assert resident_kilobytes() - before < 4096


def test_a_port_that_is_taken_is_said():
    with fuse_flow.StreamServer(0) as server:
        with pytest.raises(RuntimeError, match=str(server.port)):
            fuse_flow.StreamServer(server.port)


def test_an_end_is_not_closed_under_the_thread_that_uses_it():
    server = fuse_flow.StreamServer(0)
    client = fuse_flow.StreamClient(server.link)
    pulled = []
    thread = threading.Thread(target=lambda: pulled.append(client.pull(3)))
    thread.start()
    time.sleep(0.2)
    with pytest.raises(RuntimeError, match="StreamClient is in use by another thread"):
        client.close()
    thread.join()
    assert pulled == [None]
    client.close()
    server.close()


def test_the_interpreter_ends_cleanly_with_a_stream_open():
    program = textwrap.dedent("""
        import threading, time
        import fuse_flow
        from rigs import wall_frame
        cloud = fuse_flow.FuseFlow().fuse(wall_frame())
        server = fuse_flow.StreamServer(0)
        client = fuse_flow.StreamClient(server.link)
        def pull():
            while True:
                client.pull(10)
        threading.Thread(target=pull, daemon=True).start()
        for _ in range(5):
            server.publish(cloud)
            time.sleep(0.02)
        def publish():
            while True:
                server.publish(cloud.points, colors=cloud.colors)
        threading.Thread(target=publish, daemon=True).start()
        time.sleep(0.1)
    """)
    run = subprocess.run([sys.executable, "-c", program], cwd=os.path.dirname(__file__), capture_output=True, text=True, timeout=60)
    assert_ended_cleanly(run)
