"""Checks of live pages: they follow a slider, a file, a link and a record."""

import json
import os
import re
import subprocess
import time
import urllib.request
from contextlib import contextmanager

from browse.made import DATASET, FEELER, ROOT, shipped
from browse.sound import check

SLIDER_STEPS = 40
# With FEELER_LONG every n-th of the shipped scenarios is timed.
EVERY = 5
# Scenarios whose live page is timed. The goal is not a test, because the time depends on the computer.
WANTED_MS = 50
LIVE = ["chatter/sustained", "control/lead", "paper/all-three", "contact/hard-wall"]
# Scenarios whose runs take the longest computation.
SLOW = ["paper/landmarks-free", "paper/landmarks-clamped", "why/loss-fast", "why/loss-close"]

def refused(address):
    try:
        urllib.request.urlopen(address, timeout=5)
    except urllib.error.HTTPError as error:
        return error.code == 404
    return False


@contextmanager
def serving(*words):
    """`feeler live`, until the end of the block: its process and address."""
    command = subprocess.Popen(
        [FEELER, "live", *map(str, words)],
        cwd=ROOT,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        text=True,
    )
    try:
        yield command, command.stdout.readline().strip()
    finally:
        command.kill()
        command.wait()


# The state of a map.
TOLD = "return document.querySelector('#map').dataset."
COARSE, FILLED, DONE = TOLD + "coarse", TOLD + "filled", TOLD + "done"
# The ranges of the curves, as their legends show them.
RANGES = "return [...document.querySelectorAll('.u-legend')].map((one) => one.textContent).join()"
READY = (
    "return document.querySelector('footer').dataset.latency && document.querySelector('#lead').textContent"
)
SETTLED = "return !document.body.dataset.busy"


LEADING_KNOB = """
const gain = JSON.parse(document.getElementById("data").textContent).gain;
const knob = document.getElementById(`knob-${gain}`) ?? document.querySelector(".knob input[type=range]");
knob.closest("details").open = true;
knob.scrollIntoView({ block: "center" });
return knob;
"""


def dragged(browser, steps):
    """Drags the slider of the leading gain, and returns the median time from a move to its picture."""
    browser.drag(browser.run(LEADING_KNOB), [(2, 0)] * steps)
    browser.wait(SETTLED, "the last state")
    return browser.run("return document.querySelector('footer').dataset.latency")


def timed(browser, problems):
    """Times how fast pages of shipped scenarios follow a slider; with FEELER_LONG every fifth of all."""
    names = [f"scenarios/{name}.toml" for name in LIVE + SLOW]
    is_long = bool(os.environ.get("FEELER_LONG"))
    if is_long:
        names += [file for file in shipped()[::EVERY] if file not in names]
    late = []
    for name in names:
        with serving(name) as (_, address):
            browser.ask("POST", "/url", {"url": address})
            before = browser.wait(READY, "the first state")
            ranges = browser.run(RANGES)
            # The map fills in while nothing moves.
            coarse = float(browser.wait(COARSE, "the coarse map", DONE))
            whole = ""
            if is_long:
                filled = float(browser.wait(FILLED, "the map", DONE))
                whole = f", whole in {filled:.0f} ms"
            median = dragged(browser, SLIDER_STEPS // 2)
            print(f"live {name}: {median}; the map is coarse in {coarse:.0f} ms{whole}")
            late += [name] if float(median.split()[0]) > WANTED_MS else []
            lead = browser.run("return document.querySelector('#lead').textContent")
            if "In motion" in lead:
                problems.append(f"live {name}: the whole run does not follow the beginning")
            if name in names[: len(LIVE)] and lead == before:
                problems.append(f"live {name}: a slider that was dragged moves nothing")
            if name in names[: len(LIVE)] and browser.run(RANGES) == ranges:
                problems.append(f"live {name}: legends keep the ranges of the first state")
    slow = ", ".join(late) or "none"
    print(f"{len(late)} of {len(names)} live pages take more than {WANTED_MS} ms: {slow}")


def live_on_records(browser, axe_text, shots, problems):
    with serving(DATASET / "machine.toml", "--data", DATASET) as (_, address):
        check(browser, "live-records", address, axe_text, shots, problems)
        browser.wait("return document.querySelectorAll('#records .chart').length", "the record's charts")
        drawn = "return [...document.querySelectorAll('#records canvas')].map((c) => c.toDataURL()).join('')"
        browser.wait(SETTLED, "the first state")
        time.sleep(0.5)
        before = browser.run(drawn)
        browser.run(
            "const knob = document.getElementById('knob-springs.guide.damping');"
            " knob.closest('details').open = true; knob.scrollIntoView({ block: 'center' })"
        )
        browser.drag(browser.find("#knob-springs\\.guide\\.damping"), [(3, 0)] * (SLIDER_STEPS // 4))
        time.sleep(0.2)
        browser.wait(
            drawn.replace("return ", "return (") + f") !== {json.dumps(before)}",
            "the prediction that was moved",
        )


def live(browser, axe_text, shots, problems, out):
    def wrong(what):
        problems.append(f"live: {what}")

    file = out / "live.toml"
    file.write_text((ROOT / "files/src/templates/flexible.toml").read_text())
    with serving(file) as (command, address):
        host = re.match(r"(http://127\.0\.0\.1:\d+)/([0-9a-f]{32})/$", address)
        if not host:
            raise AssertionError(f"no address: {address}")
        for other in ("/", "/" + "0" * 32 + "/", f"/{host[2]}/../live.toml", f"/{host[2]}/state"):
            if not refused(host[1] + other):
                wrong(f"{other} is answered")
        check(browser, "live", address, axe_text, shots, problems)
        browser.ask("POST", "/url", {"url": address})
        before = browser.wait(READY, "the first state")
        # The map fills in while nothing moves.
        filled = float(browser.wait(FILLED, "the map", DONE))
        latency = dragged(browser, SLIDER_STEPS)
        after = browser.run("return document.querySelector('#lead').textContent")
        if after == before or "#" not in browser.run("return location.href"):
            wrong("a slider that was dragged moves nothing")
        print("live:", latency, f"; the map fills in {filled:.0f} ms")
        if shots:
            browser.shot(shots / "live-moved.png")
        link = browser.run("return location.href")
        browser.ask("POST", "/url", {"url": "about:blank"})
        browser.ask("POST", "/url", {"url": link})
        browser.wait(READY, "the state of the link")
        browser.wait(SETTLED, "the state of the link")
        if browser.run("return document.querySelector('#lead').textContent") != after:
            wrong("a link does not hold the state")
        browser.run(
            "[...document.querySelectorAll('.acts button')].find((b) => b.textContent === 'Pin').click()"
        )
        browser.drag(browser.find("#knob-controllers\\.force\\.kp"), [(-3, 0)] * 10)
        browser.wait(SETTLED, "the state after the pin")
        if "pinned" not in browser.run("return document.querySelector('#force').textContent"):
            wrong("nothing is pinned")
        browser.drag(browser.find("#knob-controllers\\.force\\.reference\\.1\\.1"), [(3, 0)] * 5)
        browser.wait(SETTLED, "the state after a point of the reference")
        text = file.read_text()
        browser.run(
            "[...document.querySelectorAll('.acts button')]"
            ".find((b) => b.textContent === 'Write to file').click()"
        )
        browser.wait("return document.querySelector('#told').textContent", "what is written")
        written = file.read_text()
        comments = lambda t: re.findall(r"#.*", t)
        points = lambda t: re.search(r"(?m)^reference = \[\[0\.0, 20\.0\], \[1\.0, (.+)\]\]", t)
        if not points(written) or points(written)[1] == points(text)[1]:
            wrong("a point of the reference is not written")
        if (
            written == text
            or comments(written) != comments(text)
            or (out / "live.toml.bak").read_text() != text
        ):
            wrong("writing to the file changes nothing, loses comments, or keeps no copy")
        said = browser.run("return document.querySelector('#lead').textContent")
        file.write_text(re.sub(r"(?m)^kp\s*=.*$", "kp = 0.05", written))
        browser.wait(
            f"return document.querySelector('#lead').textContent !== {json.dumps(said)}",
            "the edited file",
        )
        file.write_text(written.replace("[bodies.tip]", "[bodies.tipp]"))
        browser.wait(
            "return document.querySelector('#problem').textContent", "the mistake of the edited file"
        )
        # The message stays while a slider moves, and disappears with the mistake.
        browser.drag(browser.find("#knob-controllers\\.force\\.kp"), [(3, 0)] * 3)
        browser.wait(SETTLED, "the state beside a mistake")
        told = browser.run("return document.querySelector('#problem').textContent")
        if not re.search(r"live\.toml:\d+:\d+: ", told):
            wrong(f"the mistake of the file has no place: {told!r}")
        if browser.run("return document.querySelector('#problem').textContent.includes('`')"):
            wrong("a mistake is shown with backticks")
        file.write_text(written)
        browser.wait(
            "return !document.querySelector('#problem').textContent && !document.body.dataset.busy",
            "the corrected file",
        )
        command.terminate()
        command.wait()
        browser.wait(
            "return document.querySelector('#problem').textContent.includes('ended')",
            "the end of the command",
        )
