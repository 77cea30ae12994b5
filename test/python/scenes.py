"""Depth images of a corner of a room with a ball in it, by the equations of planes and spheres."""

import numpy

import fuse_flow

WIDTH, HEIGHT, FOCAL = 200, 150, 170.0


def look(eye, at):
    """A pose at eye, which looks at a point; z of the world is up."""
    eye, at = numpy.asarray(eye, float), numpy.asarray(at, float)
    forward = (at - eye) / numpy.linalg.norm(at - eye)
    right = numpy.cross(forward, (0, 0, 1))
    right /= numpy.linalg.norm(right)
    pose = numpy.eye(4)
    pose[:3, :3] = numpy.stack([right, numpy.cross(forward, right), forward], axis=1)
    pose[:3, 3] = eye
    return pose


def rays_of(camera):
    K = camera.intrinsics
    v, u = numpy.mgrid[: K.height, : K.width]
    rays = numpy.stack([(u - K.cx) / K.fx, (v - K.cy) / K.fy, numpy.ones_like(u, float)], axis=-1)
    return rays @ camera.T_world_camera[:3, :3].T, camera.T_world_camera[:3, 3]


def depth_of(camera, ball=(0.7, 0.8, 0.4), radius=0.4):
    """z of the nearest of three planes, x = 0, y = 0 and z = 0, and a ball; float32, metres."""
    rays, eye = rays_of(camera)
    with numpy.errstate(divide="ignore", invalid="ignore"):
        depths = [numpy.where(rays[..., k] < 0, -eye[k] / rays[..., k], numpy.inf) for k in range(3)]
        to = eye - numpy.asarray(ball)
        a, b, c = (rays**2).sum(-1), rays @ to, to @ to - radius**2
        root = numpy.sqrt(b * b - a * c)
        depths.append(numpy.where(numpy.isnan(root), numpy.inf, (-b - root) / a))
    return numpy.min(depths, axis=0).astype(numpy.float32)


def pattern_of(camera, depth):
    """Grey levels that follow the place in the world, so that cameras see the same pattern."""
    rays, eye = rays_of(camera)
    x, y, z = numpy.moveaxis(eye + depth[..., None] * rays, -1, 0)
    grey = 128 + 40 * numpy.sin(23 * x + 5 * z) + 40 * numpy.sin(19 * y - 7 * z) + 40 * numpy.sin(13 * z + 11 * x * y)
    return numpy.repeat(numpy.clip(grey, 0, 255).astype(numpy.uint8)[..., None], 3, axis=2)


def corner_frame(eyes=((2.2, 1.6, 1.3), (1.9, 2.1, 1.2), (1.5, 2.3, 1.5), (2.4, 1.1, 1.6)), color=False):
    K = fuse_flow.Intrinsics(WIDTH, HEIGHT, FOCAL, FOCAL, (WIDTH - 1) / 2, (HEIGHT - 1) / 2)
    cameras = [fuse_flow.Camera(K, look(eye, (0.5, 0.5, 0.4)), name=f"camera {i}") for i, eye in enumerate(eyes)]
    depths = [depth_of(camera) for camera in cameras]
    colors = [pattern_of(camera, depth) if color else None for camera, depth in zip(cameras, depths)]
    return fuse_flow.RigFrame(cameras, [fuse_flow.DepthView(depth, image) for depth, image in zip(depths, colors)])


def poses_of(frame):
    return numpy.stack([camera.T_world_camera for camera in frame.cameras])


def moved(pose, translation, degrees, axis=(0, 0, 1)):
    """The pose, moved and turned a little about its own place."""
    axis = numpy.asarray(axis, float) / numpy.linalg.norm(axis)
    K = numpy.cross(numpy.eye(3), axis)
    angle = numpy.radians(degrees)
    out = pose.copy()
    out[:3, :3] = (numpy.eye(3) + numpy.sin(angle) * K + (1 - numpy.cos(angle)) * K @ K) @ pose[:3, :3]
    out[:3, 3] += translation
    return out


def apart(a, b):
    """Metres between the centres of two cameras."""
    return numpy.linalg.norm(a[:3, 3] - b[:3, 3])
