"""Checks for pages of any kind: nothing throws, hangs or is too small, in light and dark colours."""

import json
import os
import re
import shutil
import subprocess
import tempfile
import time
from pathlib import Path

WIDE, NARROW = 1400, 420
LEAST_PX = 11
# Largest processor time of the main thread, s. On a slower computer it is longer in proportion to the time
# of some sums, which take 0.16 s on a fast one. Other processes do not count.
MOST_CPU_S, SUMS_S = 1.0, 0.16
SUMS = "let sum = 0; for (let i = 1; i < 1e8; i++) sum += 1 / i; return sum"
# Smallest contrast of text and of bold text by WCAG, and of lines that are still visible.
LEAST_CONTRAST, LEAST_BOLD, LEAST_LINE = 4.5, 3.0, 1.3
# Largest number of printed pages: for pages with a chart for each signal or record, and for all others.
MOST_PAPER = {"run": 9, "diagnose": 20, "analyze": 11, "analyze-servo": 11, "compare-records": 14}
OTHER_PAPER = 8

SMALL_TEXT = """
const found = [];
const walk = document.createTreeWalker(document.querySelector("main"), NodeFilter.SHOW_TEXT);
while (walk.nextNode()) {
  const holder = walk.currentNode.parentElement, text = walk.currentNode.textContent.trim();
  if (!text || !holder.getClientRects().length || holder.closest("script, style, title")) continue;
  let px = parseFloat(getComputedStyle(holder).fontSize);
  const svg = holder.closest("svg");
  if (svg && svg.viewBox.baseVal.width) px *= svg.getBoundingClientRect().width / svg.viewBox.baseVal.width;
  if (px < arguments[0] - 0.05) found.push(`${px.toFixed(1)} px: ${text.slice(0, 40)}`);
}
return found;
"""
# Tables and maps that are partly hidden.
CUT = """
const folded = [...document.querySelectorAll("main details:not([open])")];
folded.forEach((fold) => { fold.open = true; });
const cut = [...document.querySelectorAll(".scroll, .plot .map")]
  .filter((box) => box.scrollWidth > box.clientWidth + 1)
  .map((box) => `${box.scrollWidth - box.clientWidth} px of ${box.getAttribute("aria-label")}`);
folded.forEach((fold) => { fold.open = false; });
return cut;
"""
# Sentences with backticks, except in the printed text of a file.
QUOTED = """
const walk = document.createTreeWalker(document.querySelector("main"), NodeFilter.SHOW_TEXT), found = [];
while (walk.nextNode()) {
  const holder = walk.currentNode.parentElement;
  if (walk.currentNode.textContent.includes("`") && !holder.closest("pre, script, style")) {
    found.push(walk.currentNode.textContent.slice(0, 120));
  }
}
return found;
"""
UNREACHED = """
return [...document.querySelectorAll(".chart, .plane, .map, .scroll, input, select, button")]
  .filter((e) => e.getClientRects().length && e.tabIndex < 0).map((e) => e.outerHTML.slice(0, 120));
"""
# Drawings whose values do not change with an arrow key. The map of a live page moves its sliders instead.
DEAF = """
const deaf = [];
for (const place of document.querySelectorAll(".chart, .plane, .map[data-map]")) {
  if (!place.getClientRects().length) continue;
  // A sentence in place of a chart.
  if (place.matches(".chart") && !place.querySelector("canvas") && place.textContent) continue;
  const read = () => place.textContent + (place.nextElementSibling?.textContent ?? "");
  const before = read();
  place.focus();
  document.activeElement.dispatchEvent(new KeyboardEvent("keydown", { key: "ArrowRight", bubbles: true }));
  if (read() === before) deaf.push(place.outerHTML.slice(0, 120));
}
document.activeElement.blur();
return deaf;
"""
# Charts of rounding errors: their values span less than the rounding of their size, or of one dB or degree.
# Of drawings, the numbers at the ticks.
NOISE = """
const data = JSON.parse(document.getElementById("data")?.textContent ?? "{}"), found = [];
const spans = (values, floor) => {
  const all = Array.from(values).filter((v) => v != null && Number.isFinite(v));
  const low = all.reduce((m, v) => Math.min(m, v), Infinity);
  const high = all.reduce((m, v) => Math.max(m, v), -Infinity);
  return high - low > Math.max(1e-9 * Math.max(Math.abs(low), Math.abs(high)), floor);
};
for (const place of document.querySelectorAll(".chart[data-chart]")) {
  const chart = data.charts[place.dataset.chart], label = chart.y.label;
  const floor = /\\((dB|°)\\)$/.test(label) ? 1e-6 : chart.y.log ? 0 : 1e-12;
  const values = chart.series.flatMap((series) => Array.from(feeler.column(series.values)));
  values.push(...chart.lines.map((line) => line.y), ...chart.marks.map((mark) => mark.y));
  if (!spans(values, floor)) found.push(`${place.getAttribute("aria-label")} draws rounding or nothing`);
}
for (const ticks of document.querySelectorAll("main svg .ticks")) {
  const numbers = [...ticks.querySelectorAll("text")].map((text) =>
      Number(text.textContent.replace("\\u2212", "-"))).filter(Number.isFinite);
  if (numbers.length > 1 && !spans(numbers, 0)) found.push(`ticks ${numbers.slice(0, 4)}`);
}
return found;
"""
# Boxes without content or word.
EMPTY = """
const boxes = document.querySelectorAll("main figure, main table, main .tiles, main .bars, main pre");
return [...boxes].filter((box) => box.getClientRects().length && !box.textContent.trim()
    && !box.querySelector("canvas, svg *"))
  .map((box) => box.outerHTML.slice(0, 120));
"""
# Boxes that scroll without a shadow at the edge.
NO_CUE = """
return [...document.querySelectorAll("main *")].filter((box) => {
  const style = getComputedStyle(box);
  const scrolls = (over, inner, outer) => /auto|scroll/.test(over) && inner > outer + 1;
  return box.getClientRects().length && (scrolls(style.overflowX, box.scrollWidth, box.clientWidth)
    || scrolls(style.overflowY, box.scrollHeight, box.clientHeight))
    && !/gradient/.test(style.backgroundImage) && getComputedStyle(box, "::after").position !== "sticky";
}).map((box) => box.outerHTML.slice(0, 120));
"""
# Charts whose vertical axis has no legible letter.
PALE_AXES = """
const parse = (text) => (text.match(/[\\d.]+/g) ?? []).map(Number);
const linear = (c) => c / 255 <= 0.04045 ? c / 255 / 12.92 : ((c / 255 + 0.055) / 1.055) ** 2.4;
const light = ([r, g, b]) => 0.2126 * linear(r) + 0.7152 * linear(g) + 0.0722 * linear(b);
const ground = light(parse(getComputedStyle(document.body).backgroundColor));
const seen = [...document.querySelectorAll(".chart canvas")].filter((e) => e.getClientRects().length);
return seen.map((canvas) => {
  const over = canvas.parentNode.querySelector(".u-over").getBoundingClientRect();
  const width = Math.max(1, Math.floor(over.left - canvas.getBoundingClientRect().left - 8));
  const { data } = canvas.getContext("2d").getImageData(0, 0, width, canvas.height);
  let best = 1;
  for (let i = 0; i < data.length; i += 4) {
    if (data[i + 3] < 200) continue;
    const ink = light(data.subarray(i, i + 3));
    best = Math.max(best, (Math.max(ink, ground) + 0.05) / (Math.min(ink, ground) + 0.05));
  }
  return [best, canvas.getAttribute("aria-label")];
}).filter(([best]) => best < arguments[0]).map(([best, name]) => `${best.toFixed(2)}: ${name}`);
"""
AXE = """
const done = arguments[arguments.length - 1];
axe.run(document, { resultTypes: ["violations"] }).then((found) => done(found.violations
  .filter((v) => v.impact === "serious" || v.impact === "critical")
  .map((v) => `${v.id}: ${v.nodes.slice(0, 3).map((n) => n.html.slice(0, 160)).join(" | ")}`)));
"""
# Text and lines whose contrast with their background is too low.
FAINT = """
const [least, leastBold, leastLine] = arguments;
const parse = (text) => {
  const v = (text.match(/[\\d.]+/g) ?? []).map(Number);
  return text.startsWith("rgb") ? [v[0], v[1], v[2], v[3] ?? 1] : null;
};
const over = (a, b) => [0, 1, 2].map((i) => a[3] * a[i] + (1 - a[3]) * b[i]).concat(1);
const linear = (c) => c / 255 <= 0.04045 ? c / 255 / 12.92 : ((c / 255 + 0.055) / 1.055) ** 2.4;
const light = (c) => 0.2126 * linear(c[0]) + 0.7152 * linear(c[1]) + 0.0722 * linear(c[2]);
const contrast = (a, b) => {
  const [x, y] = [light(a), light(b)];
  return (Math.max(x, y) + 0.05) / (Math.min(x, y) + 0.05);
};
const ground = parse(getComputedStyle(document.body).backgroundColor);
const found = [];
for (const svg of document.querySelectorAll("main svg")) {
  for (const text of svg.querySelectorAll("text")) {
    const box = text.getBoundingClientRect(), style = getComputedStyle(text);
    if (!box.width || !text.textContent.trim()) continue;
    let below = ground;
    const layers = document.elementsFromPoint(box.x + box.width / 2, box.y + box.height / 2)
      .filter((e) => svg.contains(e) && e instanceof SVGGeometryElement
        && text.compareDocumentPosition(e) & Node.DOCUMENT_POSITION_PRECEDING);
    for (const layer of layers.reverse()) {
      const of = getComputedStyle(layer), fill = parse(of.fill);
      if (fill) below = over([...fill.slice(0, 3), fill[3] * Number(of.fillOpacity)], below);
    }
    const ink = parse(style.fill);
    const reached = ink ? contrast(over(ink, below), below) : 0;
    if (reached < (Number(style.fontWeight) >= 600 ? leastBold : least)) {
      found.push(`${reached.toFixed(2)}: ${text.textContent.slice(0, 30)} (${style.fill} on ${below})`);
    }
  }
  for (const shape of svg.querySelectorAll("path, line, circle")) {
    const style = getComputedStyle(shape), ink = parse(style.stroke);
    if (!ink || !shape.getClientRects().length) continue;
    const reached = contrast(over(ink, ground), ground);
    // Of the ground's own colour are the edges of lines over a map.
    if (reached > 1.02 && reached < leastLine) found.push(`${reached.toFixed(2)}: a line (${style.stroke})`);
  }
}
return found;
"""


def axe():
    """The source of axe-core, or None."""
    kept = os.environ.get("AXE")
    if kept:
        return Path(kept).read_text()
    with tempfile.TemporaryDirectory() as folder:
        if (
            not shutil.which("npm")
            or subprocess.run(["npm", "pack", "axe-core@4"], cwd=folder, capture_output=True).returncode
        ):
            return None
        subprocess.run("tar xzf axe-core-*.tgz", shell=True, cwd=folder, check=True)
        return Path(folder, "package/axe.min.js").read_text()


def most_cpu_s(browser):
    """Largest processor time of a page on this computer, s: one second on a fast computer."""
    if not hasattr(browser, "sums_s"):
        before = browser.cpu_s()
        browser.run(SUMS)
        browser.sums_s = browser.cpu_s() - before
    return MOST_CPU_S * max(1.0, browser.sums_s / SUMS_S)


def check(browser, name, address, axe_text, shots, problems):
    def wrong(what):
        problems.append(f"{name}: {what}")

    browser.look(WIDE)
    # After its command has ended, a live page keeps sending requests until another page opens.
    browser.ask("POST", "/url", {"url": "about:blank"})
    browser.log("browser"), browser.log("performance")
    cpu_s = browser.open(address)
    if cpu_s > most_cpu_s(browser):
        wrong(f"works for {cpu_s:.2f} s")
    time.sleep(0.3)
    for line in browser.log("browser"):
        if line["level"] == "SEVERE":
            wrong(line["message"][:300])
    for line in browser.log("performance"):
        message = json.loads(line["message"])["message"]
        if message["method"] == "Network.requestWillBeSent":
            url = message["params"]["request"]["url"]
            if not re.match(r"(file|data|blob):|http://127\.0\.0\.1:", url):
                wrong(f"asks for {url}")
    if browser.run("return document.body.innerText.includes('could not be drawn')"):
        wrong("a chart could not be drawn")
    if quoted := browser.run(QUOTED):
        wrong(f"backticks in {quoted[:3]}")
    if unreached := browser.run(UNREACHED):
        wrong(f"keys do not reach {unreached[:3]}")
    if noise := browser.run(NOISE):
        wrong(f"charts of rounding errors: {noise[:4]}")
    if deaf := browser.run(DEAF):
        wrong(f"an arrow key shows no value of {deaf[:3]}")
    for dark in (False, True):
        for width in (WIDE, NARROW):
            browser.look(width, dark)
            time.sleep(0.35)
            if empty := browser.run(EMPTY):
                wrong(f"empty boxes at {width} px: {empty[:3]}")
            if no_cue := browser.run(NO_CUE):
                wrong(f"boxes at {width} px that scroll without a cue: {no_cue[:3]}")
            if shots:
                browser.shot(shots / f"{name}-{width}-{'dark' if dark else 'light'}.png")
            if width == NARROW and not dark:
                if small := browser.run(SMALL_TEXT, LEAST_PX):
                    wrong(f"small text at {NARROW} px: {small[:4]}")
                if cut := browser.run(CUT):
                    wrong(f"tables or maps that {NARROW} px do not hold: {cut[:3]}")
                overflow = browser.run("return document.documentElement.scrollWidth - innerWidth")
                if overflow > 1:
                    wrong(f"is {overflow} px wider than {NARROW} px")
        # The browser finds the element below a text only within the window. The page may be longer when wide.
        browser.look(WIDE, dark)
        browser.look(WIDE, dark, browser.run("return Math.min(document.documentElement.scrollHeight, 30000)"))
        time.sleep(0.2)
        if faint := browser.run(FAINT, LEAST_CONTRAST, LEAST_BOLD, LEAST_LINE):
            wrong(f"{len(faint)} faint in the {'dark' if dark else 'light'}: {faint[:4]}")
        if pale := browser.run(PALE_AXES, LEAST_CONTRAST):
            wrong(f"pale axes in the {'dark' if dark else 'light'}: {pale[:4]}")
        if axe_text:
            browser.look(WIDE, dark)
            browser.run(axe_text + "; window.axe = axe")
            for finding in browser.ask("POST", "/execute/async", {"script": AXE, "args": []}):
                wrong(f"axe, {'dark' if dark else 'light'}: {finding}")
    browser.look(WIDE)
    paper = browser.paper()
    if paper > MOST_PAPER.get(name, OTHER_PAPER):
        wrong(f"prints {paper} pages of paper")
