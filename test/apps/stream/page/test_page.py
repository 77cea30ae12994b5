"""The page in a browser, without a screen, as a person meets it.

    test_page.py --page FOLDER --files FOLDER (--chromium PROGRAM --driver PROGRAM | --firefox PROGRAM) [--screenshots FOLDER]
                 [--serve fuse_flow_serve] [--viewer fuse_flow_viewer [--display "xvfb-run -a"]] [TEST ...]

The stream comes from other_server.py, which does what a test tells it, and, with --serve, from fuse_flow_serve as well. Nothing here
depends on how fast anything is: what is to happen is waited for. Exit code 77: something that it needs is not installed.
"""

import argparse
import contextlib
import math
import pathlib
import re
import shlex
import struct
import subprocess
import sys
import tempfile
import time
import traceback

try:
    from selenium import webdriver
    from selenium.webdriver.chrome.options import Options
    from selenium.webdriver.chrome.service import Service
    from selenium.webdriver.common.action_chains import ActionChains
    from selenium.webdriver.common.actions.action_builder import ActionBuilder
    from selenium.webdriver.common.keys import Keys
    import websockets  # noqa: F401  other_server.py needs it
except ImportError as error:
    print(f"skipped: {error}")
    sys.exit(77)

from firefox import Firefox
from other_server import OtherServer, records
from pictures import color_difference, intersection_over_union, read_png, silhouette

PATIENCE = 90  # seconds, for what takes a fraction of one: software draws, and other tests run

# What is on the canvas, by the page's own picture: how many pixels are not the background, and the shares of them that are red and green.
PIXELS = """
const {drawing} = fuse_flow;
drawing.changed = true;
drawing.draw();
const gl = drawing.renderer.getContext();
const width = gl.drawingBufferWidth, height = gl.drawingBufferHeight;
const data = new Uint8Array(4 * width * height);
gl.readPixels(0, 0, width, height, gl.RGBA, gl.UNSIGNED_BYTE, data);
let drawn = 0, red = 0, green = 0;
for (let at = 0; at < data.length; at += 4) {
  const r = data[at], g = data[at + 1], b = data[at + 2];
  if (Math.abs(r - 20) + Math.abs(g - 23) + Math.abs(b - 28) < 12) continue;
  ++drawn;
  if (r > 120 && r > 2 * g && r > 2 * b) ++red;
  if (g > 120 && g > 2 * r && g > 2 * b) ++green;
}
return {width, height, all: width * height, drawn, red, green};
"""


class Page:
    """A browser with the page. Its driver: what Selenium's and Firefox's have in common."""

    firefox = False

    def __init__(self, driver, arguments):
        self.driver = driver
        self.screenshots = pathlib.Path(arguments.screenshots) if arguments.screenshots else None

    def open(self, address):
        self.driver.get(address)

    def run(self, script, *arguments):
        return self.driver.execute_script(script, *arguments)

    def get(self, expression):
        return self.run(f"return ({expression})")

    def until(self, expression, what=None):
        """Waits until it holds."""
        end = time.monotonic() + PATIENCE
        while time.monotonic() < end:
            with contextlib.suppress(Exception):
                value = self.get(expression)
                if value:
                    return value
            time.sleep(0.1)
        raise AssertionError(f"it never came: {what or expression}; the page says: {self.text('text')!r}")

    def until_frame(self, more=1):
        """Until so many more frames have been drawn."""
        begin = self.get("globalThis.fuse_flow?.shown ? fuse_flow.frames : 0")
        self.until(f"globalThis.fuse_flow?.shown && fuse_flow.frames >= {begin + more}", f"{more} more frames")

    def draw_again(self):
        """Until what is set now is on the screen: that is some pictures of the screen later than it is drawn."""
        begin = self.get("fuse_flow.drawing.drawn")
        self.run("fuse_flow.drawing.changed = true")
        self.until(f"fuse_flow.drawing.drawn > {begin}")
        self.driver.execute_async_script("""
          const done = arguments[arguments.length - 1];
          let left = 5;
          const wait = () => (left-- > 0 ? requestAnimationFrame(wait) : done());
          wait()""")

    def text(self, element):
        with contextlib.suppress(Exception):
            return self.get(f"document.getElementById('{element}').innerText")
        return ""

    def click(self, element):
        self.drag(self.run("const box = document.getElementById(arguments[0]).getBoundingClientRect(); return [box.x + box.width / 2, box.y + box.height / 2]", element))

    def pixels(self):
        return self.run(PIXELS)

    def place(self):
        return self.get("fuse_flow.place")

    def screenshot(self, name):
        if self.screenshots:
            self.screenshots.mkdir(parents=True, exist_ok=True)
            (self.screenshots / f"{name}.png").write_bytes(self.driver.get_screenshot_as_png())


class ChromiumPage(Page):
    def __init__(self, arguments, more=()):
        options = Options()
        options.binary_location = arguments.chromium
        # No sandbox, as root has none. SwiftShader draws where there is no graphics card.
        for argument in ["--headless=new", "--no-sandbox", "--disable-dev-shm-usage", "--use-angle=swiftshader", "--enable-unsafe-swiftshader",
                         "--window-size=800,700", "--force-device-scale-factor=1", "--disable-background-networking", "--no-first-run", *more]:
            options.add_argument(argument)
        options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
        driver = webdriver.Chrome(service=Service(arguments.driver), options=options)
        driver.set_script_timeout(PATIENCE)
        super().__init__(driver, arguments)

    def key(self, *keys, held=None):
        chain = ActionChains(self.driver)
        if held:
            chain.key_down(held)
        for key in keys:
            chain.send_keys(key)
        if held:
            chain.key_up(held)
        chain.perform()

    def drag(self, *places):
        """Of the mouse: pressed at the first place of the window, released at the last; one place: a click."""
        mouse = ActionBuilder(self.driver)
        for number, (x, y) in enumerate(places):
            mouse.pointer_action.move_to_location(round(x), round(y))
            if number == 0:
                mouse.pointer_action.pointer_down()
        mouse.pointer_action.pointer_up()
        mouse.perform()

    def complaints(self):
        """What the browser complains of, but for connections that the test ended."""
        return [entry["message"] for entry in self.driver.get_log("browser")
                if entry["level"] == "SEVERE" and "WebSocket connection" not in entry["message"]]


class FirefoxPage(Page):
    firefox = True

    def __init__(self, arguments):
        super().__init__(Firefox(arguments.firefox, PATIENCE), arguments)
        self.driver.set_window_size(800, 600)

    def key(self, *keys, held=None):
        self.driver.keys(*keys, held=held)

    def drag(self, *places):
        self.driver.drag(*places)

    def complaints(self):
        """As above."""
        entries, self.driver.log = self.driver.log, []
        return [entry["text"] for entry in entries if entry["level"] == "error" and "ws://" not in (entry["text"] or "")]


def sphere(arguments):
    return pathlib.Path(arguments.files) / "sphere.ffs"


def check(condition, what=""):
    assert condition, what


def other_server(arguments, **options):
    return OtherServer(arguments.page, sphere(arguments), **options)


@contextlib.contextmanager
def serving(server):
    server.start()
    try:
        yield server
    finally:
        server.stop()


@contextlib.contextmanager
def served(arguments, stream_file):
    """By fuse_flow_serve; gives its link."""
    process = subprocess.Popen([arguments.serve, str(stream_file), "--port", "0"], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    try:
        link = None
        for line in process.stdout:
            link = re.search(r"https?://\S+", line)
            if link:
                break
        check(link, "it prints a link")
        yield link.group()
    finally:
        process.terminate()
        process.wait(30)


# ---- the tests: names are what holds


def test_it_shows_what_is_streamed(page, arguments):
    with serving(other_server(arguments)) as server:
        page.open(server.address)
        page.until_frame(4)
        seen = page.pixels()
        page.screenshot("live")
        check(seen["drawn"] > 0.1 * seen["all"], f"the picture is nearly empty: {seen}")
        check(seen["red"] > 0.01 * seen["all"] and seen["green"] > 0.02 * seen["all"], f"no red sphere above a green floor: {seen}")
        check("sphere" in page.get("document.title"))
        page.until("document.getElementById('state').textContent === 'Live'")
        page.until("document.getElementById('n-points').textContent === '40,000'")
        for number in ("n-frames", "n-network", "n-decoding", "n-delay"):
            page.until(f"/\\d/.test(document.getElementById('{number}').textContent)", f"a figure in {number}")
        # Names of cameras are text, whatever they are.
        names = page.get("[...document.querySelectorAll('.name')].map((name) => name.textContent)")
        check(names == ["left", "<b>right</b>"], str(names))
        check(server.unanswered_most <= 2 and server.closed_by_rule == 0, "it does not keep to the rules")
        got = [message["frame"] for message in server.received if message["type"] == "got"]
        check(got == sorted(got) and len(got) >= 3, str(got))


def test_it_keeps_to_its_policy_and_complains_of_nothing(page, arguments):
    with serving(other_server(arguments)) as server:
        page.open(server.address)
        page.until_frame(2)
        page.key("h")
        page.until("document.getElementById('help').open")
        page.screenshot("help")
        page.key(Keys.ESCAPE)
        page.until("!document.getElementById('help').open")
        for key in "456790ugygandkt+-bbr":
            page.key(key)
        page.key("t", "n", "4")
        page.until_frame(1)
        check(page.complaints() == [], str(page.complaints()))
        own = {path.split("?")[0] for path in server.requests}
        check(all(path == "/" or path == "/stream" or (pathlib.Path(arguments.page) / path[1:]).is_file() for path in own), str(own))


def test_it_stops_and_steps_through_the_last_frames(page, arguments):
    with serving(other_server(arguments)) as server:
        page.open(server.address)
        page.until_frame(5)
        page.key(" ")
        page.until("fuse_flow.place.playing === false")
        page.until("fuse_flow.idle", "all is drawn")
        newest = page.get("fuse_flow.shown.frame.number")
        page.key(Keys.ARROW_LEFT)
        page.until(f"fuse_flow.shown.frame.number === {newest - 1}")
        page.key(Keys.ARROW_LEFT)
        page.until(f"fuse_flow.shown.frame.number === {newest - 2}")
        page.key(Keys.ARROW_RIGHT)
        page.until(f"fuse_flow.shown.frame.number === {newest - 1}")
        page.screenshot("stepped_back")
        page.key(Keys.HOME)
        page.until("fuse_flow.place.index === 0")
        page.key(Keys.END)
        page.until("fuse_flow.place.index === fuse_flow.place.count - 1")
        # On from the last one is one more of the server's, and no more.
        before = page.get("fuse_flow.shown.frame.number")
        page.key(Keys.ARROW_RIGHT)
        page.until(f"fuse_flow.shown.frame.number > {before}")
        check(page.place()["playing"] is False)
        # While it is stopped nothing is asked for: after a while the connection is given up.
        page.until("document.getElementById('state').textContent.startsWith('Paused.')")
        sent = server.sent
        page.click("play")
        page.until_frame(3)
        check(page.place()["playing"] is True and server.sent > sent)


def test_several_workers_decode_for_the_page(page, arguments):
    with serving(OtherServer(arguments.page, pathlib.Path(arguments.files) / "room.ffs")) as server:
        page.open(server.address + "?decoders=3")
        page.until("fuse_flow.decoders === 3")
        page.until_frame(4)
        check(page.pixels()["drawn"] > 10000)
        check(page.complaints() == [], str(page.complaints()))


def test_a_damaged_frame_is_told_of_and_left_out(page, arguments):
    def flip(at):
        def damage(message):
            at_byte = at if at >= 0 else len(message) + at
            return message[:at_byte] + bytes([message[at_byte] ^ 0x55]) + message[at_byte + 1:]
        return damage
    with serving(other_server(arguments)) as server:
        page.open(server.address)
        page.until_frame(2)
        damages = [flip(60), flip(-1000), lambda message: message[:len(message) // 2], lambda message: b"", lambda message: message + b"x",
                   lambda message: b"FFC1" + b"\xff" * 1000]
        for count, damage in enumerate(damages, 1):
            server.damage = damage
            page.until(f"document.getElementById('n-lost').textContent.startsWith('{count} frame')", f"damage {count} is told of")
            page.until_frame(2)
        page.screenshot("damaged")
        check(page.pixels()["drawn"] > 1000)


def test_it_connects_again_when_the_server_comes_back(page, arguments):
    server = other_server(arguments)
    server.start()
    page.open(server.address)
    page.until_frame(2)
    server.stop()
    page.until("document.getElementById('dot').classList.contains('bad')", "it says that the connection is gone")
    page.until("/Next try/.test(document.getElementById('state').textContent)")
    page.screenshot("disconnected")
    check(page.pixels()["drawn"] > 1000, "the last frame is still there")
    with serving(server):
        page.until_frame(2)
        page.until("document.getElementById('state').textContent === 'Live'")


def test_a_token_goes_with_the_request(page, arguments):
    with serving(other_server(arguments, token="0123456789abcdef")) as server:
        page.open(server.address)
        page.until("/token/.test(document.getElementById('state').textContent)", "it says that a token is needed")
        page.open(server.address + "?token=0123456789abcdef")
        page.until_frame(1)


def test_it_draws_in_a_window_of_another_size(page, arguments):
    with serving(other_server(arguments)) as server:
        page.open(server.address)
        page.until_frame(1)
        try:
            for width, height in ((420, 800), (1300, 500), (800, 700)):
                page.driver.set_window_size(width, height)
                page.until(f"innerWidth <= {width} && innerWidth > {width - 40}")
                page.until("document.getElementById('canvas').width === innerWidth && document.getElementById('canvas').height === innerHeight")
                page.until_frame(1)
                seen = page.pixels()
                check(seen["drawn"] > 0.02 * seen["all"], str(seen))
                overflow = page.get("document.documentElement.scrollWidth > innerWidth || document.getElementById('bar').getBoundingClientRect().right > innerWidth")
                check(not overflow, f"at {width} pixels something is outside")
                page.screenshot(f"window_{width}")
        finally:
            page.driver.set_window_size(800, 700)


def test_it_draws_again_after_the_graphics_card_was_lost(page, arguments):
    with serving(other_server(arguments)) as server:
        page.open(server.address)
        page.until_frame(2)
        page.run("globalThis.loss = fuse_flow.drawing.renderer.getContext().getExtension('WEBGL_lose_context'); loss.loseContext()")
        page.until("fuse_flow.drawing.renderer.getContext().isContextLost()")
        page.run("loss.restoreContext()")
        page.until("!fuse_flow.drawing.renderer.getContext().isContextLost()")
        page.until_frame(2)
        page.until(f"(() => {{ {PIXELS.strip()} }})().red > 1000", "the sphere is there again")


def test_wishes_go_to_the_server(page, arguments):
    with serving(other_server(arguments)) as server:
        page.open(server.address)
        page.until_frame(2)

        def wanted():
            wants = [message for message in server.received if message["type"] == "want"]
            return wants[-1] if wants else {}

        def until_wanted(condition, what):
            end = time.monotonic() + PATIENCE
            while not condition(wanted()):
                check(time.monotonic() < end, f"never wished: {what}; {wanted()}")
                time.sleep(0.1)
        page.key("b")
        until_wanted(lambda want: "region" in want, "a region")
        region = wanted()["region"]
        check(all(low < high for low, high in zip(region["min"], region["max"])), str(region))
        # A handle is dragged: the box is smaller, and fewer pixels are drawn.
        before = page.pixels()
        handle = page.run("""
          const {drawing} = fuse_flow;
          const handle = drawing.handles.find(({userData: {axis, side}}) => axis === 0 && side === 1);
          const at = drawing.onScreen(handle.position.clone().add(drawing.boxObject.position));
          const to = drawing.onScreen(drawing.boxObject.position);
          return {x: at.x, y: at.y, dx: to.x - at.x, dy: to.y - at.y}""")
        page.drag(*[(handle["x"] + share * handle["dx"], handle["y"] + share * handle["dy"]) for share in (0, 0.5, 1)])
        until_wanted(lambda want: "region" in want and want["region"]["max"][0] < region["max"][0] - 0.05, "a smaller region")
        page.screenshot("crop_box")
        check(page.pixels()["drawn"] < before["drawn"], "points outside of the box are drawn")
        page.key("b")
        until_wanted(lambda want: "region" not in want, "no region")
        page.run("const list = document.getElementById('most-points'); list.value = '20000'; list.dispatchEvent(new Event('change'))")
        until_wanted(lambda want: want.get("points") == 20000 and len(want["viewpoint"]) == 3, "fewer points")


def test_two_points_are_measured(page, arguments):
    with serving(other_server(arguments)) as server:
        page.open(server.address)
        page.until_frame(2)
        page.key(" ")
        page.until("fuse_flow.place.playing === false && fuse_flow.idle")
        # Two points of the cloud that nothing hides, and where they are on the screen.
        points = page.run("""
          const {drawing} = fuse_flow;
          const frame = drawing.cloud.frame;
          const out = [];
          for (let i = 0; i < frame.points && out.length < 2; i += 97) {
            const at = drawing.onScreen(drawing.pointOf(frame, i));
            if (!at || at.x < 330 || at.y < 220 || at.x > 760 || at.y > 480) continue;
            if (out.length && Math.hypot(at.x - out[0].x, at.y - out[0].y) < 80) continue;
            const x = Math.round(at.x), y = Math.round(at.y);
            const hit = drawing.pick(x, y);
            if (hit) out.push({x, y, position: hit.position.toArray()});
          }
          return out""")
        check(len(points) == 2)
        page.click("measure")
        for point in points:
            page.drag((point["x"], point["y"]))
        page.until("document.querySelector('.mark')?.textContent.endsWith(' mm')", "a distance")
        shown = float(page.get("document.querySelector('.mark').textContent").split()[0])
        true = 1000 * sum((a - b) ** 2 for a, b in zip(points[0]["position"], points[1]["position"])) ** 0.5
        page.screenshot("measured")
        check(abs(shown - true) < 60, f"{shown} mm, and should be about {true} mm")  # as near as a pixel is
        page.key(Keys.ESCAPE)
        page.until("document.querySelector('.mark') === null")


def test_mouse_wheel_and_keys_move_the_view(page, arguments):
    with serving(other_server(arguments)) as server:
        page.open(server.address)
        page.until_frame(2)
        where = "[...fuse_flow.drawing.camera.position.toArray(), ...fuse_flow.drawing.controls.target.toArray()].map((x) => x.toFixed(4)).join()"

        def touch(begin, end):
            def send(kind, points):
                page.driver.execute_cdp_cmd("Input.dispatchTouchEvent", {"type": kind, "touchPoints": [{"x": x, "y": y, "id": k} for k, (x, y) in enumerate(points)]})
            send("touchStart", begin)
            send("touchMove", [((a + c) / 2, (b + d) / 2) for (a, b), (c, d) in zip(begin, end)])
            send("touchMove", end)
            send("touchEnd", [])

        actions = {
            "drag": lambda: page.drag((400, 300), (440, 315), (480, 330)),
            "wheel": lambda: page.run("document.getElementById('canvas').dispatchEvent(new WheelEvent('wheel', {deltaY: -300, clientX: 400, clientY: 300, cancelable: true}))"),
            "one finger": lambda: touch([(400, 250)], [(460, 270)]),
            "two fingers": lambda: touch([(350, 250), (450, 250)], [(300, 250), (500, 250)]),
            "turn": lambda: page.key(Keys.ARROW_RIGHT, held=Keys.SHIFT),
            "move": lambda: page.key(Keys.ARROW_UP, held=Keys.CONTROL),
            "zoom": lambda: page.key(Keys.ARROW_UP),
            "fit": lambda: page.key("r"),
        }
        for name, action in actions.items():
            if page.firefox and "finger" in name:
                continue  # Chromium's driver only has touch here
            before = page.get(where)
            action()
            page.until(f"{where} !== '{before}'", f"the view changes: {name}")


def test_colours_are_by_what_is_chosen(page, arguments):
    with serving(other_server(arguments)) as server:
        page.open(server.address)
        page.until_frame(2)
        page.key(" ")
        page.until("fuse_flow.place.playing === false && fuse_flow.idle")
        page.until("document.querySelector('[name=color][value=normal]').disabled === false", "the frames have normals")
        seen = {}
        for key, name in (("4", "rgb"), ("5", "confidence"), ("6", "views"), ("7", "height"), ("9", "normal")):
            page.key(key)
            page.until(f"fuse_flow.drawing.look.colorBy === '{name}'")
            pixels = page.pixels()
            seen[name] = (pixels["red"], pixels["green"])
            check(pixels["drawn"] > 1000)
            page.screenshot(f"by_{name}")
        check(len(set(seen.values())) == 5, f"colours do not differ: {seen}")


def test_files_are_played(page, arguments):
    with serving(other_server(arguments)) as server:
        page.open(server.address + "?file=frames.ffs")
        page.until_frame(3)
        check("File frames.ffs" in page.text("state"))
        page.until("fuse_flow.place.count === 6 && fuse_flow.place.live === false")
        page.key(" ")
        page.until("fuse_flow.place.playing === false")
        page.key(Keys.HOME)
        page.until("fuse_flow.place.index === 0 && fuse_flow.shown.frame.number === 0")
        page.key(Keys.ARROW_RIGHT)
        page.until("fuse_flow.place.index === 1 && fuse_flow.shown.frame.number === 1")
        page.key(Keys.ARROW_LEFT, Keys.ARROW_LEFT)
        page.until("fuse_flow.place.index === 5")
        check(not any(path.split("?")[0] == "/stream" for path in server.requests))
        # A file that is dropped on the page, and one that is none.
        drop = """
          const [path, cut] = arguments;
          const done = arguments[arguments.length - 1];
          fetch(path).then((response) => response.arrayBuffer()).then((bytes) => {
            const transfer = new DataTransfer();
            transfer.items.add(new File([cut ? bytes.slice(0, cut) : bytes], 'dropped.ffs'));
            document.body.dispatchEvent(new DragEvent('drop', {dataTransfer: transfer, bubbles: true, cancelable: true}));
            done();
          })"""
        page.driver.execute_async_script(drop, "frames.ffs", 0)
        page.until("document.getElementById('state').textContent.startsWith('File dropped.ffs')")
        page.until_frame(2)
        page.driver.execute_async_script(drop, "frames.ffs", sphere(arguments).stat().st_size - 5)
        page.until("/cut off/.test(document.getElementById('state').textContent)")
        page.until("fuse_flow.place.count === 5")
        page.driver.execute_async_script(drop, "page.js", 0)
        page.until("/no stream file/.test(document.getElementById('state').textContent)")
        page.until_frame(2)  # what was there goes on


def test_the_address_says_which_way_is_up(page, arguments):
    with serving(other_server(arguments)) as server:
        for query, up in (("", [0, 0, 1]), ("?up=-y", [0, -1, 0]), ("?up=x", [1, 0, 0]), ("?up=nonsense", [0, 0, 1])):
            page.open(server.address + query)
            page.until_frame(1)
            check(page.get("fuse_flow.drawing.up.toArray()") == up, query)


def link_to(view):
    return "?up=z&view=" + ",".join(f"{value:g}" for value in view)


def test_the_address_says_where_the_view_is_from(page, arguments):
    with serving(other_server(arguments)) as server:
        place = "[...fuse_flow.drawing.camera.position.toArray(), ...fuse_flow.drawing.controls.target.toArray(), fuse_flow.drawing.camera.fov]"

        def near(values, view):
            return all(abs(a - b) < 2e-3 for a, b in zip(values, view))
        view = [2.5, -3, 1.75, 0.25, 0.5, 0.4, 38]
        page.open(server.address + link_to(view))
        page.until_frame(1)
        check(near(page.get(place), view), str(page.get(place)))
        page.key("v")  # a link to another view
        check(page.get("new URLSearchParams(location.search).get('view')") == "2.5,-3,1.75,0.25,0.5,0.4,38")
        page.run("fuse_flow.drawing.turn(0.5, 0.1)")
        page.key("v")
        turned = page.get(place)
        check(not near(turned, view))
        page.open(page.get("location.href"))
        page.until_frame(1)
        check(near(page.get(place), turned), f"{page.get(place)}, not {turned}")
        page.key("r")
        check(not near(page.get(place), turned), "everything is shown")
        for wrong in ("1,2,3", "1,2,3,4,5,six", "1,2,3,1,2,3", "1,2,3,4,5,6,0", "1,2,3,4,5,6,7,8", "1,,3,4,5,6", ""):
            page.open(server.address + "?view=" + wrong)
            page.until("/^view is/.test(document.getElementById('note').textContent)", f"{wrong!r} is refused")
            page.until_frame(1)
            check(page.get(place)[6] >= 45, "the start is as without it")


def test_the_picture_is_the_viewers_from_the_same_place(page, arguments):
    """The screenshot of Chromium and that of fuse_flow_viewer, of the same stream file."""
    if not (arguments.serve and arguments.viewer):
        print("    not done: no --serve, or no --viewer")
        return
    room = pathlib.Path(arguments.files) / "room.ffs"
    background = (20, 23, 28)
    points, zoom = 4, 0.75
    view = [1.9, -3.2, 2.3, 0.05, 0.1, 0.35]
    with tempfile.TemporaryDirectory() as folder, served(arguments, room) as link:
        fov = 30 / zoom  # of the viewer, where it is told where to stand

        def screenshot(place):
            page.open(link + link_to([*place, fov]))
            page.until_frame(1)
            # Nothing but points, of the viewer's size.
            page.run("""
              fuse_flow.drawing.setLook({size: arguments[0], byDistance: false, cameras: false});
              for (const part of ['text', 'bar', 'names', 'note', 'legend', 'settings']) document.getElementById(part).style.display = 'none'""", points)
            page.draw_again()
            return read_png(page.driver.get_screenshot_as_png())
        ours = screenshot(view)
        page.screenshot("as_the_viewer")
        file = pathlib.Path(folder) / "viewer.png"
        command = [*arguments.display, arguments.viewer, str(room), "--offscreen", "--screenshot", str(file), "--width", str(ours.width), "--height", str(ours.height),
                   "--from", *map(str, view[:3]), "--at", *map(str, view[3:]), "--up", "0", "0", "1", "--zoom", str(zoom), "--point-size", str(points), "--press", "y,t"]
        run = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, timeout=PATIENCE, check=False)
        check(run.returncode == 0 and file.is_file(), run.stdout)
        theirs = read_png(file.read_bytes())
        if page.screenshots:
            (page.screenshots / "the_viewer.png").write_bytes(file.read_bytes())
        check((theirs.width, theirs.height) == (ours.width, ours.height), "their sizes differ")
        theirs_drawn = silhouette(theirs, background)
        check(0.15 < sum(theirs_drawn) / len(theirs_drawn) < 0.9, "the viewer's picture is of nothing")

        def likeness(picture):
            return intersection_over_union(silhouette(picture, background), theirs_drawn), color_difference(picture, theirs, background)

        def alike(iou, difference):
            return iou > 0.97 and difference < 3
        iou, difference = likeness(ours)
        print(f"    silhouettes: intersection over union {iou:.4f}; colours differ by {difference:.2f} of 255")
        check(alike(iou, difference), f"the pictures differ: {iou}, {difference}")
        # What would be wrong is seen: each of these is told from the viewer's picture.
        x, y, z = view[0] - view[3], view[1] - view[4], view[2]
        angle = math.radians(5)
        orbited = [view[3] + math.cos(angle) * x - math.sin(angle) * y, view[4] + math.sin(angle) * x + math.cos(angle) * y, z, *view[3:]]
        wrong = {"mirrored": ours.mirrored(), "upside down": ours.upside_down(), "turned by 5 degrees": ours.turned(5, bytes(background)),
                 "from 5 degrees beside": screenshot(orbited), "red and blue swapped": ours.red_and_blue_swapped(),
                 "10 pixels beside": ours.moved(10, 0, bytes(background))}
        for name, picture in wrong.items():
            iou, difference = likeness(picture)
            print(f"    {name}: {iou:.4f}; {difference:.2f}")
            check(not alike(iou, difference), f"a picture that is {name} would pass")


# SwiftShader's Vulkan for the compositor, too: else it cannot show what WebGPU draws.
WEBGPU_OPTIONS = ["--enable-unsafe-webgpu", "--use-webgpu-adapter=swiftshader", "--enable-features=Vulkan", "--use-vulkan=swiftshader", "--ignore-gpu-blocklist"]


def test_webgpu_draws_what_webgl_draws(page, arguments):
    if page.firefox:
        print("    not done: Firefox has no WebGPU without a graphics card")
        return
    background = (20, 23, 28)
    view = [2.2, -2.6, 1.9, 0, 0, 0.5, 45]
    # File, and what is pressed: colours by each; the crop box, marks, grid and axes; points of a size in metres. Points of 4 pixels, as the
    # outlines of smaller ones are rounded to pixels in two ways.
    cases = [("sphere", "4"), ("sphere", "5"), ("sphere", "6"), ("sphere", "7"), ("sphere", "9"), ("sphere", "4bga"), ("sphere", "4d"), ("wide", "4r"),
             ("one_layer", "4r")]
    browser = ChromiumPage(arguments, WEBGPU_OPTIONS)
    try:
        with serving(other_server(arguments)) as server:
            browser.open(server.address)
            if not browser.driver.execute_async_script("""
              const done = arguments[arguments.length - 1];
              Promise.resolve(navigator.gpu?.requestAdapter()).then((adapter) => done(Boolean(adapter)), () => done(false))"""):
                print("    not done: this Chromium has no adapter for WebGPU")
                return

            def opened(renderer, file):
                server.stream_file = pathlib.Path(arguments.files) / f"{file}.ffs"
                browser.open(f"{server.address}{link_to(view)}&file=frames.ffs&renderer={renderer}")
                browser.until_frame(1)
                browser.until("fuse_flow.place?.live === false")
                browser.run("if (fuse_flow.place.playing) document.getElementById('play').click()")
                browser.key(Keys.HOME)
                browser.until("!fuse_flow.place.playing && fuse_flow.place.index === 0 && fuse_flow.shown.frame.number === 0 && fuse_flow.idle")

            def screenshot(keys, marks):
                browser.run("fuse_flow.drawing.setLook({size: 4, byDistance: false}); document.getElementById('by-distance').checked = false")
                browser.key(*keys)
                browser.run("""
                  const {drawing} = fuse_flow;
                  const {frame} = drawing.cloud;
                  if (arguments[0]) drawing.setMarks([0.3, 0.6].map((share) => drawing.pointOf(frame, Math.floor(share * frame.points))), '1 mm');
                  for (const part of ['text', 'bar', 'note', 'legend', 'settings']) document.getElementById(part).style.display = 'none'""", marks)
                browser.draw_again()
                return read_png(browser.driver.get_screenshot_as_png())
            for file, keys in cases:
                pictures = {}
                for renderer, api in (("webgl", "WebGL 2"), ("webgpu", "WebGPU")):
                    opened(renderer, file)
                    check(browser.get("fuse_flow.drawing.api") == api and browser.get("document.getElementById('drawn-by').textContent") == api, api)
                    pictures[renderer] = screenshot(keys, "b" in keys)
                    if browser.screenshots:
                        browser.screenshot(f"{renderer}_{file}_{keys[:4]}")
                drawn = {renderer: silhouette(picture, background) for renderer, picture in pictures.items()}
                iou = intersection_over_union(*drawn.values())
                difference = color_difference(*pictures.values(), background)
                print(f"    {file}, {keys}: silhouettes: intersection over union {iou:.4f}; colours differ by {difference:.2f} of 255")
                check(sum(drawn["webgl"]) > 0.03 * len(drawn["webgl"]), "the picture is of nothing")
                check(iou > 0.97 and difference < 3, f"{file}, {keys}: the pictures differ: {iou}, {difference}")
            # Frames of other sizes and kinds one after the other: buffers are made anew, or not.
            for file in ("empty", "sphere", "wide", "room", "all_fields"):
                server.stream_file = pathlib.Path(arguments.files) / f"{file}.ffs"
                frames = browser.get("fuse_flow.frames")
                browser.driver.execute_async_script("""
                  const [name, done] = arguments;
                  fetch('frames.ffs').then((response) => response.blob()).then((blob) => fuse_flow.openFile(new File([blob], name))).then(done)""", file)
                browser.until(f"document.getElementById('state').textContent.startsWith('File {file}') && fuse_flow.frames > {frames}")
                browser.screenshot(f"webgpu_then_{file}")
            complaints = browser.complaints()
            check(complaints == [], str(complaints))
            # The device is lost: the same view by WebGL.
            opened("webgpu", "sphere")
            place = browser.get("fuse_flow.drawing.camera.position.toArray()")
            browser.run("fuse_flow.drawing.renderer.backend.device.destroy()")
            browser.until("fuse_flow.drawing.api === 'WebGL 2' && fuse_flow.shown")
            check(all(abs(a - b) < 2e-3 for a, b in zip(place, browser.get("fuse_flow.drawing.camera.position.toArray()"))), "another view")
    finally:
        browser.driver.quit()


def test_without_webgpu_webgl_draws(page, arguments):
    with serving(other_server(arguments)) as server:
        page.open(server.address + "?renderer=webgpu")
        page.until_frame(2)
        if page.get("fuse_flow.drawing.api") == "WebGPU":
            print("    not done: this browser has WebGPU")
            return
        page.until("/WebGL 2 draws/.test(document.getElementById('note').textContent)", "it says so")
        check(page.pixels()["drawn"] > 1000)
        check(page.complaints() == [], str(page.complaints()))


def test_the_decoder_gives_the_same_here_as_the_library(page, arguments):
    """For where there is no node."""
    files = sorted(pathlib.Path(arguments.files).glob("*.ffs"))
    check(len(files) > 3)
    with serving(other_server(arguments)) as server:
        for path in files:
            server.stream_file = path
            page.open(server.address + "licences.txt")
            points = page.driver.execute_async_script("""
              const done = arguments[arguments.length - 1];
              (async () => {
                const {FrameDecoder, positionOf} = await import('/decoder.js');
                const {Zstandard} = await import('/zstandard.js');
                const {StreamFile} = await import('/stream_file.js');
                const decoder = new FrameDecoder(await Zstandard.load());
                const file = await StreamFile.open(await (await fetch('/frames.ffs')).blob());
                const frame = decoder.decode(await file.read(0));
                const sum = [0, 0, 0];
                for (let i = 0; i < frame.points; ++i) positionOf(frame, i).forEach((value, axis) => (sum[axis] += value));
                return {count: frame.points, sum};
              })().then(done, (error) => done({error: error.message}))""")
            expected = path.with_suffix(".points").read_bytes()
            count = struct.unpack_from("<I", expected)[0]
            check(points.get("count") == count, f"{path.name}: {points}")
            values = struct.unpack_from(f"<{3 * count}f", expected, 4)
            for axis in range(3):
                check(abs(points["sum"][axis] - sum(values[axis::3])) < 1e-3 * (1 + count), f"{path.name}: {points}")


def test_several_workers_decode_what_one_decodes(page, arguments):
    with serving(other_server(arguments)) as server:
        for name in ("room", "wide", "chroma", "all_fields"):
            server.stream_file = pathlib.Path(arguments.files) / f"{name}.ffs"
            page.open(server.address + "licences.txt")
            seen = page.driver.execute_async_script("""
              const done = arguments[arguments.length - 1];
              (async () => {
                const {DecodeTeam} = await import('/decode_team.js');
                const {StreamFile} = await import('/stream_file.js');
                const file = await StreamFile.open(await (await fetch('/frames.ffs')).blob());
                const message = await file.read(0);
                const team = await DecodeTeam.make(4, {fewPoints: 0});
                while (!team.helpers.every((helper) => helper.ready)) await new Promise((ready) => setTimeout(ready, 10));
                const words = (frame) => JSON.stringify([frame.points, ...['positions', 'colors', 'normals', 'masks'].map((name) => Array.from(frame[name] ?? []))]);
                const alone = words(team.decoder.decode(message));
                const asked = team.helpers.map(() => 0);
                team.helpers.forEach((helper, k) => {
                  const {decode} = helper;
                  helper.decode = (...share) => {
                    ++asked[k];
                    return decode.apply(helper, share);
                  };
                });
                const pool = [];
                const same = [];
                for (let k = 0; k < 3; ++k) {  // again with the memory of before
                  const frame = await team.decode(message, pool);
                  same.push(words(frame) === alone);
                  for (const array of [frame.positions, frame.colors, frame.normals, frame.masks]) if (array) pool.push(array.buffer);
                }
                const damaged = message.slice();
                damaged[damaged.length - 20] ^= 0x55;  // of the last chunk: not this worker's
                const error = await team.decode(damaged, []).then(() => 'none', (failure) => failure.message);
                same.push(words(await team.decode(message, pool)) === alone);
                const other = await DecodeTeam.make(2, {fewPoints: 0, patience: 500});
                while (!other.helpers[0].ready) await new Promise((ready) => setTimeout(ready, 10));
                other.helpers[0].worker.terminate();  // it never answers
                same.push(words(await other.decode(message, [])) === alone);
                return {points: JSON.parse(alone)[0], asked, same, error};
              })().then(done, (error) => done({error: error.stack}))""")
            check(seen.get("same") == [True] * 5, f"{name}: {seen}")
            check(seen["error"] not in ("none", ""), f"{name}: {seen}")
            check(name != "room" or min(seen["asked"]) >= 4, f"{name}: {seen}")


def test_fuse_flow_serve_and_the_page_understand_each_other(page, arguments):
    if not arguments.serve:
        print("    not done: no --serve")
        return
    with served(arguments, sphere(arguments)) as link:
        page.complaints()
        page.open(link)
        page.until_frame(4)
        page.screenshot("fuse_flow_serve")
        seen = page.pixels()
        check(seen["red"] > 0.01 * seen["all"] and seen["green"] > 0.02 * seen["all"], str(seen))
        page.key("b")
        page.until_frame(4)
        page.until("fuse_flow.shown.frame.points < 40000 || fuse_flow.shown.frame.pointsOfFrame === 40000")
        page.key(" ")
        page.until("document.getElementById('state').textContent.startsWith('Paused.')")
        page.key(" ")
        page.until_frame(3)
        check(page.complaints() == [], str(page.complaints()))


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--page", required=True)
    parser.add_argument("--files", required=True)
    parser.add_argument("--chromium", default="/usr/bin/chromium")
    parser.add_argument("--driver", default="/usr/bin/chromedriver")
    parser.add_argument("--firefox", help="this instead of Chromium")
    parser.add_argument("--screenshots")
    parser.add_argument("--serve")
    parser.add_argument("--viewer")
    parser.add_argument("--display", type=shlex.split, default=[], help="what gives the viewer a display: 'xvfb-run -a'")
    parser.add_argument("tests", nargs="*")
    arguments = parser.parse_args()
    records(sphere(arguments).read_bytes())
    tests = [(name, test) for name, test in globals().items() if name.startswith("test_") and (not arguments.tests or any(t in name for t in arguments.tests))]
    failed = []
    page = FirefoxPage(arguments) if arguments.firefox else ChromiumPage(arguments)
    try:
        for name, test in tests:
            begin = time.monotonic()
            try:
                test(page, arguments)
                print(f"ok      {name} ({time.monotonic() - begin:.1f} s)", flush=True)
            except Exception:  # noqa: BLE001  the others are still to be run
                traceback.print_exc()
                for line in page.complaints():
                    print("    browser:", line)
                page.screenshot(f"failed_{name}")
                print(f"FAILED  {name}", flush=True)
                failed.append(name)
    finally:
        page.driver.quit()
    print(f"{len(tests)} tests, {len(failed)} failed")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
