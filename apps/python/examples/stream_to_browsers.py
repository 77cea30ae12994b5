"""stream_to_browsers.py RECORDING: fuses a recording again and again, and streams the clouds until Ctrl-C.

It prints a link, which browsers, fuse_flow_viewer and StreamClient open.
"""

import sys
import time

import fuse_flow

recording = fuse_flow.open(sys.argv[1])
fusion = fuse_flow.FuseFlow()
with fuse_flow.StreamServer(port=0) as server:  # 0: a port that is free; for this machine alone
    server.describe("fused in Python", recording.cameras)
    print(server.link, flush=True)
    for warning in server.warnings:
        print(warning, file=sys.stderr)
    while True:
        for frame in recording:
            server.publish(fusion.fuse(frame), captured=time.time_ns())
            time.sleep(1 / (recording.frames_per_second or 30))
