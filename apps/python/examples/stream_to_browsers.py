"""stream_to_browsers.py RECORDING | DEVICE…: fuses cameras as they run, and streams the clouds until Ctrl-C.

A recording is played again and again, as if its cameras ran now. The link that is printed opens in browsers, in fuse_flow_viewer and in
StreamClient.
"""

import sys
import time

import fuse_flow

fusion = fuse_flow.FuseFlow()
with fuse_flow.LiveRig(sys.argv[1:], loop=True) as rig, fuse_flow.StreamServer(port=0) as server:
    server.describe("fused in Python", rig.cameras)
    for warning in server.warnings:
        print(warning, file=sys.stderr)
    print(server.link, flush=True)
    for frame in rig:  # the newest; those that came meanwhile are left out
        came = time.time_ns()
        server.publish(fusion.fuse(frame), captured=came)
        for notice in rig.take_notices() + server.take_notices():
            print(notice, file=sys.stderr)
