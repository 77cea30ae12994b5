"""A client of another implementation: takes ten frames, answers them, asks for fewer points, and is told what is wrong."""

import asyncio
import json
import struct
import sys
from inspect import signature

import websockets


async def main(url, token):
    # As websockets 14 and later call them, or earlier versions.
    headers = next(n for n in ("additional_headers", "extra_headers") if n in signature(websockets.connect).parameters)
    options = {headers: {"Authorization": "Bearer " + token}}
    connect = websockets.connect(url, subprotocols=["other", "fuse_flow.v1"], max_size=2**26, **options)
    async with connect as socket:
        assert socket.subprotocol == "fuse_flow.v1"
        description = json.loads(await socket.recv())
        assert description["type"] == "stream" and description["version"] == 1, description

        async def frame():
            message = await socket.recv()
            assert message[:4] == b"FFC1"
            number, = struct.unpack_from("<Q", message, 8)
            await socket.send(json.dumps({"type": "got", "frame": number}))
            return number, struct.unpack_from("<II", message, 72)

        numbers = []
        for _ in range(10):
            number, (whole, points) = await frame()
            # Who answers late, as on a busy machine, gets fewer; the first one is sent before anybody knows.
            assert points == whole if not numbers else 0 < points <= whole, (whole, points)
            numbers.append(number)
        assert numbers == sorted(set(numbers)), numbers
        print(f"10 frames of {whole} points")
        await socket.send(json.dumps({"type": "want", "points": 5000}))
        for _ in range(1000):
            _, (_, points) = await frame()
            if points <= 5000:
                break
        assert points <= 5000, points
        await (await socket.ping())
        await socket.send("{}")
        try:
            while True:
                await socket.recv()
        except websockets.ConnectionClosed as closed:
            assert closed.code == 1008, closed
    try:
        await websockets.connect(url, subprotocols=["fuse_flow.v1"])
        raise AssertionError("let in without a token")
    except websockets.InvalidHandshake as refused:
        assert "HTTP 401" in str(refused), refused


asyncio.run(asyncio.wait_for(main(*sys.argv[1:]), 60))
