"""A picture of a part of a page: `shoot.py ADDRESS PICTURE WIDTH HEIGHT [SELECTOR] [HEADING]`.

It begins at the element, or at the first one that begins with that text, and ends at the right edge. A live
page is waited for, its map included.
"""

import sys
import time
from pathlib import Path

sys.dont_write_bytecode = True
sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

from browse.webdriver import Browser

TOP = """
const [selector, heading] = arguments;
const found = [...document.querySelectorAll(selector)].find((e) => e.textContent.startsWith(heading));
const { left, top } = found.getBoundingClientRect();
return [Math.max(0, left - 12), Math.max(0, top + scrollY - 4)];
"""
READY = """
const map = document.querySelector(".live #map");
return !document.body.dataset.busy && (!map || map.dataset.filled);
"""


def main(address, picture, width, height, selector="body", heading=""):
    browser = Browser()
    try:
        # All figures of a live page are in sight.
        browser.look(int(width), height=4000)
        browser.command("Emulation.setScrollbarsHidden", hidden=True)
        browser.open(address)
        browser.wait(READY, "the whole page")
        time.sleep(0.5)
        left, top = browser.run(TOP, selector, heading)
        browser.shot(Path(picture), clip=(left, top, int(width) - left, int(height)))
    finally:
        browser.close()


main(*sys.argv[1:])
