"""Checks of changed views of a page: zoomed, narrowed, moved in time."""

import re
import time

from browse.sound import WIDE


def map_zooms(browser, address, problems):
    """A box drawn on a map of a sweep zooms with new ticks, and a key shows the whole map again."""
    browser.ask("POST", "/url", {"url": address})
    seen = (
        "const svg = document.querySelector('.map svg');"
        " return [svg.querySelector('.zoomed').getAttribute('transform'),"
        " svg.querySelector('.ticks').textContent]"
    )
    _, ticks = browser.run(seen)
    browser.drag(browser.find(".map svg"), [(-30, -20)] * 4)
    zoomed, finer = browser.run(seen)
    if not zoomed or float(re.search(r"matrix\((\S+)", zoomed)[1]) < 2 or finer == ticks:
        problems.append(f"sweep-map: a box that is drawn does not zoom ({zoomed})")
    browser.run(
        "document.querySelector('.map')"
        ".dispatchEvent(new KeyboardEvent('keydown', { key: '0', bubbles: true }))"
    )
    if browser.run(seen)[1] != ticks:
        problems.append("sweep-map: the key 0 does not show the whole")


def scene_follows(browser, address, problems):
    """The picture of an arm and its charts show the same instant."""
    browser.ask("POST", "/url", {"url": address})
    seen = (
        "return [document.querySelector('.scene-controls output').textContent,"
        " document.querySelector('.chart .u-legend').textContent]"
    )
    _, legend = browser.run(seen)
    browser.run(
        "const time = document.querySelector('.scene-controls input');"
        " time.value = Math.round(time.max / 3); time.dispatchEvent(new Event('input'))"
    )
    picture, moved = browser.run(seen)
    if moved == legend:
        problems.append("run-arm: charts do not follow the picture")
    browser.run(
        "document.querySelector('.chart')"
        ".dispatchEvent(new KeyboardEvent('keydown', { key: 'ArrowRight', bubbles: true }))"
    )
    if browser.run(seen)[0] == picture:
        problems.append("run-arm: the picture does not follow a chart")


# Records each stroked path: its canvas and its horizontal positions.
STROKES = """
window.strokes = [];
for (const name of ["moveTo", "lineTo"]) {
  const own = Path2D.prototype[name];
  Path2D.prototype[name] = function (x, y) { (this.across ??= []).push(x); return own.call(this, x, y); };
}
const own = CanvasRenderingContext2D.prototype.stroke;
CanvasRenderingContext2D.prototype.stroke = function (path) {
  if (path?.across) window.strokes.push([this.canvas, path.across]);
  return path ? own.call(this, path) : own.call(this);
};
document.querySelector(".chart").scrollIntoView({ block: "center" });
return document.querySelector(".chart .u-over").clientWidth;
"""
DRAWN = """
const canvas = document.querySelector(".chart canvas");
return Math.max(...window.strokes.filter(([own]) => own === canvas).map(([, across]) => across.length));
"""
# Duration (s) and record rate (Hz) of the run `run-long`.
LONG_S, RATE_HZ = 10, 10_000


def chart_zooms(browser, address, problems):
    """Under zoom a chart of a long run draws every recorded row, not only those of the whole view."""
    browser.look(WIDE)
    browser.ask("POST", "/url", {"url": address})
    width = browser.run(STROKES)
    # Zooms twice to a tenth of the axis. The first tenth has more rows than pixels.
    for _ in range(2):
        browser.run("window.strokes = []")
        browser.drag(browser.find(".chart .u-over"), [(width / 40, 0)] * 4)
        time.sleep(0.3)
    drawn, recorded = browser.run(DRAWN), RATE_HZ * LONG_S / 100
    # The ends of the box are accurate to a pixel.
    if drawn < recorded * (1 - 20 / width):
        problems.append(f"run-long: {drawn} points are drawn where {recorded:.0f} were recorded")


# Moves across the middle of a map and up, and returns the distinct values under the pointer.
HOVERED = """
const svg = document.querySelector(".map svg"), told = document.querySelector(".map").nextElementSibling;
const [left, top, width, height] = svg.querySelector(".zoomed").dataset.frame.split(" ").map(Number);
return [0, 1].map((axis) => {
  const seen = new Set();
  for (let k = 0; k < 1000; k++) {
    const share = (k + 0.5) / 1000, [x, y] = axis ? [0.5, share] : [share, 0.5];
    const at = new DOMPoint(left + x * width, top + y * height).matrixTransform(svg.getScreenCTM());
    svg.dispatchEvent(new PointerEvent("pointermove", { clientX: at.x, clientY: at.y, bubbles: true }));
    seen.add(told.textContent.split("\\n")[0].split(", ")[1 + axis]);
  }
  return seen.size;
});
"""
FRAME = """
const svg = document.querySelector(".map svg"), at = svg.getScreenCTM();
svg.scrollIntoView({ block: "center" });
const [, , width, height] = svg.querySelector(".zoomed").dataset.frame.split(" ").map(Number);
return [width * at.a, height * at.d];
"""
# The axes of `sweep-dense`.
COLUMNS, ROWS = 210, 100


def map_shows_variants(browser, address, problems):
    """A map that draws only some of its variants shows every one of them under zoom."""
    browser.look(WIDE)
    browser.ask("POST", "/url", {"url": address})
    width, height = browser.run(FRAME)
    whole = browser.run(HOVERED)
    browser.drag(browser.find(".map svg"), [(width / 40, height / 40)] * 4)
    zoomed = browser.run(HOVERED)
    image = browser.run(
        "const image = document.querySelector('.map .zoomed image'); if (!image) return null;"
        " return fetch(image.getAttribute('href')).then((found) => found.blob())"
        ".then(createImageBitmap).then(({ width, height }) => [width, height])"
    )
    # A tenth of an axis, plus a variant that is cut at each end.
    wanted = [COLUMNS / 10, ROWS / 10]
    if whole[0] > 0.6 * COLUMNS or any(abs(found - count) > 2 for found, count in zip(zoomed, wanted)):
        problems.append(f"sweep-dense: {zoomed} variants are found where {wanted} lie; {whole} in the whole")
    if image != [COLUMNS, ROWS]:
        problems.append(f"sweep-dense: the map under zoom has {image} places for {COLUMNS} x {ROWS} variants")
