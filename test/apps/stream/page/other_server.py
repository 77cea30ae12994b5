"""A server of the page and of a stream file's frames that is not fuse_flow_serve: it does what a test tells it, as sending damaged frames.

    python3 other_server.py PAGE_FOLDER FILE.ffs [PORT] [FRAMES_A_SECOND]
"""

import asyncio
import http
import json
import pathlib
import struct
import sys
import threading
import time
import urllib.parse

import websockets

# That of fuse_flow_serve: the page has to do with it.
POLICY = ("default-src 'none'; script-src 'self' 'wasm-unsafe-eval'; worker-src 'self'; style-src 'self'; img-src 'self' data: blob:; "
          "connect-src 'self' ws://{}; base-uri 'none'; form-action 'none'; frame-ancestors 'none'")
TYPES = {".html": "text/html; charset=utf-8", ".js": "text/javascript; charset=utf-8", ".mjs": "text/javascript; charset=utf-8",
         ".css": "text/css; charset=utf-8", ".txt": "text/plain; charset=utf-8", ".ffs": "application/octet-stream"}


def crc32(data):
    import zlib
    return zlib.crc32(data) & 0xFFFFFFFF


def records(data):
    """The description's bytes, and the frames of a stream file."""
    assert data[:8] == b"FFS1\0\0\0\0", "no stream file"
    description, frames, at = None, [], 8
    while at + 8 <= len(data):
        size, kind = struct.unpack_from("<II", data, at)
        record = data[at + 8:at + 8 + size]
        if kind == 1:
            description = record
        else:
            frames.append(record)
        at += 8 + size
    return description, frames


def with_header(frame, number, captured, encoded):
    """The frame with another number and other times, and the CRC-32 that then is right."""
    header_size = struct.unpack_from("<I", frame, 4)[0]
    header = bytearray(frame[:header_size - 4])
    struct.pack_into("<Qqq", header, 8, number, captured, encoded)
    return bytes(header) + struct.pack("<I", crc32(header)) + frame[header_size:]


class OtherServer:
    """Runs in a thread of its own."""

    def __init__(self, folder, stream_file, port=0, rate=5.0, token=None):
        self.folder = pathlib.Path(folder)
        self.stream_file = pathlib.Path(stream_file)
        self.description, self.frames = records(self.stream_file.read_bytes())
        self.rate = rate
        self.token = token
        self.port = port
        self.damage = None      # a function: the bytes of the next frame → what is sent instead
        self.received = []      # messages of clients
        self.requests = []      # paths
        self.closed_by_rule = 0
        self.sent = 0
        self.unanswered_most = 0
        self.number = 0
        self._loop = asyncio.new_event_loop()
        self._thread = None
        self._server = None

    # ---- from the test

    def start(self):
        self._loop = asyncio.new_event_loop()
        self._thread = threading.Thread(target=self._run, daemon=True)
        ready = threading.Event()
        self._ready = ready
        self._thread.start()
        assert ready.wait(20), "the server does not start"
        return self

    def stop(self):
        async def end():
            self._server.close()
            await self._server.wait_closed()
        asyncio.run_coroutine_threadsafe(end(), self._loop).result(20)
        self._loop.call_soon_threadsafe(self._loop.stop)
        self._thread.join(20)

    @property
    def address(self):
        return f"http://127.0.0.1:{self.port}/"

    # ---- in its thread

    def _run(self):
        asyncio.set_event_loop(self._loop)

        async def begin():
            self._server = await websockets.serve(self._stream, "127.0.0.1", self.port, process_request=self._request,
                                                  subprotocols=["fuse_flow.v1"], max_size=4096, ping_interval=None, compression=None)
            self.port = self._server.sockets[0].getsockname()[1]
        self._loop.run_until_complete(begin())
        self._ready.set()
        self._loop.run_forever()

    async def _request(self, path, headers):
        self.requests.append(path)
        parts = urllib.parse.urlsplit(path)
        if parts.path == "/stream" and headers.get("Upgrade", "").lower() == "websocket":
            if self.token is not None and urllib.parse.parse_qs(parts.query).get("token") != [self.token]:
                return http.HTTPStatus.UNAUTHORIZED, [], b"a token is needed\n"
            return None
        if parts.path == "/frames.ffs":
            file = self.stream_file
        else:
            file = (self.folder / parts.path.lstrip("/")) if parts.path != "/" else self.folder / "index.html"
        if not file.is_file() or ".." in parts.path:
            return http.HTTPStatus.NOT_FOUND, [], b"not found\n"
        body = file.read_bytes()
        return http.HTTPStatus.OK, [("Content-Type", TYPES.get(file.suffix, "application/octet-stream")), ("Content-Security-Policy", POLICY.format(headers["Host"])),
                                    ("X-Content-Type-Options", "nosniff"), ("Cache-Control", "no-cache"), ("Connection", "close")], body

    async def _stream(self, socket, path=None):
        if socket.subprotocol != "fuse_flow.v1":
            await socket.close(1008, "the subprotocol is fuse_flow.v1")
            return
        unanswered = set()
        answered = asyncio.Event()

        async def listen():
            try:
                await answer()
            finally:
                answered.set()

        async def answer():
            async for text in socket:
                message = json.loads(text)
                self.received.append(message)
                if message.get("type") == "got":
                    if message["frame"] not in unanswered:
                        self.closed_by_rule += 1
                        await socket.close(1008, "got names a frame that was not sent, or was answered before")
                    unanswered.difference_update([number for number in unanswered if number <= message["frame"]])
                    answered.set()
                elif message.get("type") != "want":
                    self.closed_by_rule += 1
                    await socket.close(1008, "unknown message")
        listener = asyncio.ensure_future(listen())
        try:
            await socket.send(self.description.decode())
            while True:
                while len(unanswered) > 1 and socket.open:
                    answered.clear()
                    await answered.wait()
                number = self.number
                self.number += 1
                captured = time.time_ns() - 60_000_000
                message = with_header(self.frames[number % len(self.frames)], number, captured, captured + 30_000_000)
                unanswered.add(number)
                if self.damage:
                    damage, self.damage = self.damage, None
                    message = damage(message)
                await socket.send(message)
                self.sent += 1
                self.unanswered_most = max(self.unanswered_most, len(unanswered))
                await asyncio.sleep(1 / self.rate)
        except websockets.ConnectionClosed:
            pass
        finally:
            listener.cancel()


if __name__ == "__main__":
    server = OtherServer(sys.argv[1], sys.argv[2], int(sys.argv[3]) if len(sys.argv) > 3 else 8080, float(sys.argv[4]) if len(sys.argv) > 4 else 5)
    server.start()
    print(server.address, flush=True)
    threading.Event().wait()
