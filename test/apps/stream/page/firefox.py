"""Firefox without a screen, driven by WebDriver BiDi, which it speaks itself: Debian has no geckodriver, which Selenium would need."""

import asyncio
import base64
import contextlib
import json
import os
import re
import shutil
import subprocess
import tempfile
import threading

import websockets

PREFERENCES = {
    "app.update.enabled": False,
    "browser.shell.checkDefaultBrowser": False,
    "browser.startup.page": 0,
    "datareporting.policy.dataSubmissionEnabled": False,
    "network.captive-portal-service.enabled": False,
    "network.connectivity-service.enabled": False,
    "remote.active-protocols": 1,  # WebDriver BiDi
    "toolkit.telemetry.reportingpolicy.firstRun": False,
    "webgl.force-enabled": True,  # where software draws, too
}


class Firefox:
    """One window. `patience`: seconds that an answer may take."""

    def __init__(self, program, patience):
        self.patience = patience
        self.answers, self.number, self.log = {}, 0, []
        self.profile = tempfile.mkdtemp()
        with open(os.path.join(self.profile, "user.js"), "w") as file:
            for name, value in PREFERENCES.items():
                file.write(f"user_pref({json.dumps(name)}, {json.dumps(value)});\n")
        self.process = subprocess.Popen([program, "--headless", "--no-remote", "--profile", self.profile, "--remote-debugging-port", "0", "about:blank"],
                                        stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True, env={**os.environ, "HOME": self.profile})
        address = None
        for line in self.process.stderr:
            match = re.search(r"WebDriver BiDi listening on (\S+)", line)
            if match:
                address = match.group(1)
                break
        assert address, f"{program} does not listen"
        threading.Thread(target=self.process.stderr.read, daemon=True).start()  # so that it never waits for a reader
        self.loop = asyncio.new_event_loop()
        threading.Thread(target=self.loop.run_forever, daemon=True).start()
        self._wait(self._connect(address + "/session"))
        self.capabilities = self.send("session.new", capabilities={})["capabilities"]
        self.send("session.subscribe", events=["log.entryAdded"])
        self.context = self.send("browsingContext.getTree")["contexts"][0]["context"]

    def _wait(self, coroutine):
        return asyncio.run_coroutine_threadsafe(coroutine, self.loop).result(self.patience)

    async def _connect(self, address):
        self.socket = await websockets.connect(address, max_size=None, ping_interval=None)
        self.reader = asyncio.ensure_future(self._read())

    async def _read(self):
        with contextlib.suppress(websockets.ConnectionClosed):
            async for text in self.socket:
                message = json.loads(text)
                if message.get("id") in self.answers:
                    self.answers.pop(message["id"]).set_result(message)
                elif message.get("method") == "log.entryAdded":
                    self.log.append(message["params"])

    async def _ask(self, method, parameters):
        self.number += 1
        answer = self.answers[self.number] = self.loop.create_future()
        await self.socket.send(json.dumps({"id": self.number, "method": method, "params": parameters}))
        return await answer

    def send(self, method, **parameters):
        answer = self._wait(self._ask(method, parameters))
        if answer["type"] == "error":
            raise RuntimeError(f"{method}: {answer['error']}: {answer['message']}")
        return answer["result"]

    def get(self, address):
        self.send("browsingContext.navigate", context=self.context, url=address, wait="complete")

    def _call(self, function):
        answer = self.send("script.callFunction", functionDeclaration=function, target={"context": self.context}, awaitPromise=True)
        if answer["type"] == "exception":
            raise RuntimeError(answer["exceptionDetails"]["text"])
        value = answer["result"].get("value")
        return None if value is None else json.loads(value)

    def execute_script(self, script, *arguments):
        return self._call(f"() => JSON.stringify((function () {{ {script}\n }})(...{json.dumps(arguments)}))")

    def execute_async_script(self, script, *arguments):
        return self._call(f"async () => JSON.stringify(await new Promise((done) => (function () {{ {script}\n }})(...{json.dumps(arguments)}, done)))")

    def set_window_size(self, width, height):
        self.send("browsingContext.setViewport", context=self.context, viewport={"width": width, "height": height})

    def get_screenshot_as_png(self):
        return base64.b64decode(self.send("browsingContext.captureScreenshot", context=self.context)["data"])

    def keys(self, *keys, held=None):
        """Presses one after the other, meanwhile holding another. As Selenium's Keys."""
        actions = [{"type": kind, "value": key} for text in keys for key in text for kind in ("keyDown", "keyUp")]
        if held:
            actions = [{"type": "keyDown", "value": held}, *actions, {"type": "keyUp", "value": held}]
        self.send("input.performActions", context=self.context, actions=[{"type": "key", "id": "keys", "actions": actions}])

    def drag(self, *places):
        """Of the mouse: pressed at the first place of the window, released at the last; one place: a click."""
        moves = [{"type": "pointerMove", "x": round(x), "y": round(y)} for x, y in places]
        actions = [moves[0], {"type": "pointerDown", "button": 0}, *moves[1:], {"type": "pointerUp", "button": 0}]
        self.send("input.performActions", context=self.context, actions=[{"type": "pointer", "id": "mouse", "actions": actions}])

    def quit(self):
        self.process.terminate()
        self.process.wait(30)
        self.loop.call_soon_threadsafe(self.loop.stop)
        shutil.rmtree(self.profile, ignore_errors=True)
