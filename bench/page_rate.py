#!/usr/bin/env python3
"""page_rate.py ADDRESS --driver chromedriver [--chromium PROGRAM] [--seconds 10] [--size 1280x720] [--angle gl-egl|vulkan|swiftshader]

How fast the page of fuse_flow_serve draws in Chromium without a screen: what draws, the clouds of a second that come and that are drawn,
and how long one picture takes until the graphics card has finished it. Start `fuse_flow_serve FILE.ffs` first. Needs no packages.
"""

import argparse
import base64
import json
import statistics
import subprocess
import sys
import time
import urllib.request

ABOUT = """
const {drawing} = fuse_flow, {renderer, canvas} = drawing;
const about = {api: drawing.api, browser: navigator.userAgent, width: canvas.width, height: canvas.height};
if (drawing.api === 'WebGPU') {
  const {vendor, architecture, description} = renderer.backend.device.adapterInfo;
  return {...about, renderer: [vendor, architecture, description].filter(Boolean).join(' ')};
}
const gl = renderer.getContext(), names = gl.getExtension('WEBGL_debug_renderer_info');
return {...about, renderer: gl.getParameter(names ? names.UNMASKED_RENDERER_WEBGL : gl.RENDERER)};
"""

# Until the graphics card has drawn it: a pixel that is read back is there only then.
PICTURES = """
const [most, done] = arguments, {drawing} = fuse_flow, {renderer} = drawing, pixel = new Uint8Array(4), times = [];
const gl = drawing.api === 'WebGPU' ? null : renderer.getContext();
(async () => {
  for (const end = performance.now() + most; times.length < 3 || (times.length < 300 && performance.now() < end);) {
    const begin = performance.now();
    drawing.changed = true;
    drawing.draw();
    if (gl) gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, pixel);
    else await renderer.backend.device.queue.onSubmittedWorkDone();
    times.push(performance.now() - begin);
  }
  done(times);
})();
"""

COUNTS = "return {time: performance.now(), clouds: fuse_flow.frames, pictures: fuse_flow.drawing.drawn, points: fuse_flow.shown?.frame.points};"


class Browser:
    """WebDriver, spoken by hand."""

    def __init__(self, options):
        self.process = subprocess.Popen([options.driver, f"--port={options.port}"], stdout=subprocess.DEVNULL)
        self.address = f"http://127.0.0.1:{options.port}"
        arguments = ["--headless=new", "--no-sandbox", "--disable-dev-shm-usage", "--force-device-scale-factor=1", "--ignore-gpu-blocklist",
                     f"--window-size={options.size.replace('x', ',')}"] + options.argument
        if options.angle:
            arguments += ["--use-gl=angle", f"--use-angle={options.angle}"]
        if options.angle == "swiftshader":
            arguments.append("--enable-unsafe-swiftshader")
        chrome = {"args": arguments}
        if options.chromium:
            chrome["binary"] = options.chromium
        end = time.monotonic() + 30
        while True:
            try:
                session = self.call("POST", "/session", {"capabilities": {"alwaysMatch": {"browserName": "chrome", "goog:chromeOptions": chrome}}})
                break
            except ConnectionError:
                if time.monotonic() > end:
                    raise
                time.sleep(0.2)
        self.session = f"/session/{session['sessionId']}"

    def call(self, method, path, body=None):
        request = urllib.request.Request(self.address + path, method=method, data=None if body is None else json.dumps(body).encode(),
                                         headers={"Content-Type": "application/json"})
        try:
            with urllib.request.urlopen(request, timeout=120) as answer:
                return json.load(answer)["value"]
        except urllib.error.HTTPError as error:
            raise RuntimeError(json.load(error)["value"]["message"].splitlines()[0]) from None
        except urllib.error.URLError as error:
            raise ConnectionError(error.reason) from None

    def open(self, address):
        self.call("POST", self.session + "/url", {"url": address})

    def run(self, script, *arguments, how="sync"):
        return self.call("POST", f"{self.session}/execute/{how}", {"script": script, "args": list(arguments)})

    def close(self):
        if hasattr(self, "session"):
            self.call("DELETE", self.session)
        self.process.terminate()
        self.process.wait()


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("address")
    parser.add_argument("--driver", default="chromedriver")
    parser.add_argument("--chromium")
    parser.add_argument("--port", type=int, default=9515)
    parser.add_argument("--seconds", type=float, default=10)
    parser.add_argument("--size", default="1280x720")
    parser.add_argument("--angle", help="what WebGL stands on: gl-egl, vulkan, swiftshader; otherwise Chromium's choice")
    parser.add_argument("--argument", action="append", default=[], help="another of Chromium's, as --argument=--enable-logging=stderr")
    parser.add_argument("--screenshot", help="a PNG to write")
    options = parser.parse_args()
    browser = None
    try:
        browser = Browser(options)
        browser.open(options.address)
        end = time.monotonic() + 60
        while not browser.run("return Boolean(globalThis.fuse_flow?.shown) && fuse_flow.frames > 10"):
            if time.monotonic() > end:
                sys.exit("page_rate.py: no frame came within a minute")
            time.sleep(0.2)
        about = browser.run(ABOUT)
        begin = browser.run(COUNTS)
        time.sleep(options.seconds)
        after = browser.run(COUNTS)
        shown = browser.run("return document.getElementById('numbers').textContent")  # there also where the machine has no font
        times = sorted(browser.run(PICTURES, 5000, how="async"))
        seconds = (after["time"] - begin["time"]) / 1e3
        print(f"{about['renderer']}, {about['api']}, {about['browser'].split(' (')[0]} {about['browser'].rsplit(') ', 1)[-1]}")
        print(f"{about['width']} x {about['height']} pixels, {after['points']} points: {(after['clouds'] - begin['clouds']) / seconds:.1f} clouds and "
              f"{(after['pictures'] - begin['pictures']) / seconds:.1f} pictures a second, over {seconds:.1f} s")
        print(f"a picture of a cloud that is there: median {statistics.median(times):.1f} ms, 95 %: {times[int(0.95 * (len(times) - 1))]:.1f} ms, "
              f"longest {times[-1]:.1f} ms, {len(times)} pictures")
        print(" ".join(shown.split()))
        if options.screenshot:
            with open(options.screenshot, "wb") as file:
                file.write(base64.b64decode(browser.call("GET", browser.session + "/screenshot")))
    finally:
        if browser:
            browser.close()


if __name__ == "__main__":
    main()
