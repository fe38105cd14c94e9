"""Chromium by the WebDriver protocol."""

import base64
import json
import re
import socket
import subprocess
import time
import urllib.request

# Longest wait without progress, s: on any computer, a longer standstill is a hang.
STANDSTILL_S = 120


class Browser:
    """Chromium by the WebDriver protocol, which is plain HTTP."""

    def __init__(self):
        with socket.socket() as free:
            free.bind(("127.0.0.1", 0))
            port = free.getsockname()[1]
        self.driver = subprocess.Popen(
            ["chromedriver", f"--port={port}"], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
        )
        self.base = f"http://127.0.0.1:{port}"
        for _ in range(100):
            try:
                urllib.request.urlopen(self.base + "/status", timeout=5).read()
                break
            except OSError:
                time.sleep(0.1)
        arguments = [
            "--headless=new",
            "--no-sandbox",
            "--disable-gpu",
            "--disable-dev-shm-usage",
            "--disable-background-networking",
            "--disable-component-update",
            "--host-resolver-rules=MAP * ~NOTFOUND, EXCLUDE 127.0.0.1",
        ]
        wanted = {
            "browserName": "chrome",
            "goog:chromeOptions": {"args": arguments},
            "goog:loggingPrefs": {"browser": "ALL", "performance": "ALL"},
        }
        self.session = ""
        self.session = (
            "/session/" + self.ask("POST", "/session", {"capabilities": {"alwaysMatch": wanted}})["sessionId"]
        )

    def ask(self, method, path, body=None):
        data = None if method != "POST" else json.dumps(body or {}).encode()
        request = urllib.request.Request(
            self.base + self.session + path, data, {"Content-Type": "application/json"}, method=method
        )
        try:
            return json.loads(urllib.request.urlopen(request, timeout=120).read())["value"]
        except urllib.error.HTTPError as error:
            raise RuntimeError(error.read().decode()[:600]) from None

    def run(self, script, *arguments):
        return self.ask("POST", "/execute/sync", {"script": script, "args": list(arguments)})

    def wait(self, script, what, progress="return 0"):
        """Waits for the result of a script. On a slow computer only a standstill is a failure."""
        before, end = "", 0
        while not (found := self.run(script)):
            now = self.run(progress)
            if now != before:
                before, end = now, time.time() + STANDSTILL_S
            if time.time() > end:
                raise AssertionError(f"{what} does not come: nothing has moved for {STANDSTILL_S} s")
            time.sleep(0.05)
        return found

    def command(self, name, **parameters):
        return self.ask("POST", "/goog/cdp/execute", {"cmd": name, "params": parameters})

    def look(self, width, dark=False, height=900):
        self.command(
            "Emulation.setDeviceMetricsOverride",
            width=width,
            height=height,
            deviceScaleFactor=1,
            mobile=False,
        )
        self.command(
            "Emulation.setEmulatedMedia",
            media="",
            features=[{"name": "prefers-color-scheme", "value": "dark" if dark else "light"}],
        )

    def cpu_s(self):
        """Processor time of the main thread, s."""
        metrics = self.command("Performance.getMetrics")["metrics"]
        return next(metric["value"] for metric in metrics if metric["name"] == "TaskDuration")

    def open(self, address):
        """Opens a page, and returns the main thread's processor time for that, s."""
        self.command("Performance.enable", timeDomain="threadTicks")
        before = self.cpu_s()
        self.ask("POST", "/url", {"url": address})
        # The charts are drawn within two frames.
        self.ask(
            "POST",
            "/execute/async",
            {
                "script": "const done = arguments[0];"
                " requestAnimationFrame(() => requestAnimationFrame(() => done()))",
                "args": [],
            },
        )
        after = self.cpu_s()
        return after - before if after >= before else after

    def paper(self):
        """Number of printed pages."""
        printed = base64.b64decode(self.command("Page.printToPDF", printBackground=False)["data"])
        return len(re.findall(rb"/Type\s*/Page\b", printed))

    def log(self, kind):
        return self.ask("POST", "/se/log", {"type": kind})

    def shot(self, path, whole=True, clip=None):
        """A picture of the window, of the whole page, or of a clip: left, top, width and height."""
        part = {"clip": dict(zip(("x", "y", "width", "height"), clip), scale=1)} if clip else {}
        taken = self.command("Page.captureScreenshot", format="png", captureBeyondViewport=whole, **part)
        path.write_bytes(base64.b64decode(taken["data"]))

    def find(self, selector):
        return self.ask("POST", "/element", {"using": "css selector", "value": selector})

    def drag(self, element, moves):
        """Drags from the middle of an element to the right and down, in steps."""
        steps = [
            {"type": "pointerMove", "origin": element, "x": 0, "y": 0, "duration": 0},
            {"type": "pointerDown", "button": 0},
        ]
        for dx, dy in moves:
            steps += [
                {"type": "pointerMove", "origin": "pointer", "x": dx, "y": dy, "duration": 30},
                {"type": "pause", "duration": 40},
            ]
        steps.append({"type": "pointerUp", "button": 0})
        self.ask(
            "POST",
            "/actions",
            {
                "actions": [
                    {
                        "type": "pointer",
                        "id": "mouse",
                        "parameters": {"pointerType": "mouse"},
                        "actions": steps,
                    }
                ]
            },
        )

    def close(self):
        try:
            self.ask("DELETE", "")
        finally:
            self.driver.terminate()
            self.driver.wait()
