// Zooms a map within its frame, by a drawn box or by + and − about the current place. A thinned map then
// shows every variant.
feeler.zoom = (svg, thinned, about) => {
  "use strict";
  const inner = svg.querySelector(".zoomed"), marks = svg.querySelector(".ticks");
  if (!inner || !marks) return null;
  const fine = inner.classList.contains("outcomes") ? thinned : undefined;
  const NS = "http://www.w3.org/2000/svg", WHOLE = [0, 1, 0, 1];
  // A smaller box counts as a click. The smallest visible share of an axis limits the zoom.
  const SMALLEST_PX = 6, LEAST = 1e-4;
  const node = (name, attributes, text) => {
    const made = document.createElementNS(NS, name);
    for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
    if (text !== undefined) made.textContent = text;
    return made;
  };
  const [left, top, width, height, ...scales] = inner.dataset.frame.split(" ").map(Number);
  const [across, up] = [scales.slice(0, 4), scales.slice(4)];
  const value = ([from, to, log], share) => log ? from * (to / from) ** share : from + share * (to - from);
  const ratio = ([from, to, log], v) => log ? Math.log(v / from) / Math.log(to / from) :
      (v - from) / (to - from);
  const original = marks.innerHTML;
  let view = WHOLE, raster = null;
  // Converts positions in the drawing as shown to shares of the frame, to the right and up.
  const shares = ([px, py]) => [view[0] + (px - left) / width * (view[1] - view[0]),
    view[3] - (py - top) / height * (view[3] - view[2])];
  // Converts positions in the drawing as shown to the original drawing.
  const back = (point) => {
    const [x, y] = shares(point);
    return [left + x * width, top + (1 - y) * height];
  };
  const holds = ([px, py]) => px >= left && px < left + width && py >= top && py < top + height;

  const ticks = (scale, low, high, length) => {
    const ends = [value(scale, low), value(scale, high)], [a, b] = [Math.min(...ends), Math.max(...ends)];
    const all = scale[2] ? feeler.logTicks(a, b, length / 70) : feeler.linearTicks(a, b, length / 70, false);
    const texts = feeler.tickTexts(all.map((v) => v / scale[3]));
    return all.map((v, i) => [(ratio(scale, v) - low) / (high - low), texts[i]]);
  };
  const label = (x, y, align, text) => node("text", { x, y, "text-anchor": align, "font-size": 12,
    fill: "#5a646c", "font-family": "DejaVu Sans, Helvetica, Arial, sans-serif" }, text);
  const paint = () => {
    const [a, b, c, d] = view, [sx, sy] = [1 / (b - a), 1 / (d - c)];
    inner.setAttribute("transform", `matrix(${sx} 0 0 ${sy} ${left * (1 - sx) - a * width * sx} ${
      top * (1 - sy) - (1 - d) * height * sy})`);
    if (view === WHOLE) { raster?.remove(); marks.innerHTML = original; return; }
    if (fine) inner.insertBefore(raster ??= image(), inner.querySelector("[stroke]"));
    marks.replaceChildren();
    const bottom = top + height;
    for (const [share, text] of ticks(across, a, b, width)) {
      const x = left + share * width;
      marks.append(node("path", { d: `M${x} ${bottom}v6`, stroke: "#1d2226" }),
          label(x, bottom + 19, "middle", text));
    }
    for (const [share, text] of ticks(up, c, d, height)) {
      const y = top + (1 - share) * height;
      marks.append(node("path", { d: `M${left} ${y}h-6`, stroke: "#1d2226" }),
          label(left - 9, y + 4, "end", text));
    }
  };
  // One byte for each variant, from below.
  const bytes = fine && atob(fine.outcomes), at = (index) => bytes.charCodeAt(index);
  const image = () => {
    const canvas = document.createElement("canvas"), { columns, rows } = fine;
    canvas.width = columns; canvas.height = rows;
    const pixels = new ImageData(columns, rows);
    const colours = fine.colours.map((text) => [1, 3, 5].map((i) => parseInt(text.slice(i, i + 2), 16)));
    for (let row = 0; row < rows; row++) for (let column = 0; column < columns; column++) {
      const colour = colours[at(row * columns + column)];
      pixels.data.set([...colour, 255], 4 * ((rows - 1 - row) * columns + column));
    }
    canvas.getContext("2d").putImageData(pixels, 0, 0);
    return node("image", { href: canvas.toDataURL(), x: left, y: top, width, height,
      preserveAspectRatio: "none", style: "image-rendering: pixelated" });
  };
  // The variant of a thinned map at a point: its values on both axes, and its outcome.
  const variant = (point) => {
    if (!fine || view === WHOLE || !holds(point)) return null;
    const [x, y] = shares(point), { columns, rows } = fine;
    const [column, row] = [Math.floor(x * columns), Math.floor(y * rows)];
    return { values: [value(across, (column + 0.5) / columns), value(up, (row + 0.5) / rows)],
      label: fine.labels[at(row * columns + column)] };
  };

  const show = (next) => {
    const [a, b, c, d] = next;
    if (b - a < LEAST || d - c < LEAST) return;
    view = a <= 0 && b >= 1 && c <= 0 && d >= 1 ? WHOLE : [Math.max(a, 0), Math.min(b, 1), Math.max(c, 0),
      Math.min(d, 1)];
    paint();
  };
  const point = (event) => {
    const found = new DOMPoint(event.clientX, event.clientY).matrixTransform(svg.getScreenCTM().inverse());
    return [found.x, found.y];
  };
  const key = (event) => {
    const act = { "+": 0.5, "=": 0.5, "-": 2, 0: 0, Escape: 0 }[event.key];
    if (act === undefined || event.ctrlKey || event.metaKey) return false;
    const [cx, cy] = about() ?? [(view[0] + view[1]) / 2, (view[2] + view[3]) / 2];
    const [a, b, c, d] = view;
    show(act ? [cx + act * (a - cx), cx + act * (b - cx), cy + act * (c - cy), cy + act * (d - cy)] : WHOLE);
    return true;
  };
  const box = node("rect", { class: "plane-box", visibility: "hidden" });
  svg.append(box);
  let from = null, dragged = false;
  svg.addEventListener("pointerdown", (event) => {
    const start = point(event);
    dragged = false;
    if (event.button === 0 && event.pointerType !== "touch" && holds(start)) from = start;
  });
  svg.addEventListener("pointermove", (event) => {
    if (!from) return;
    const to = point(event);
    for (const [name, v] of Object.entries({ x: Math.min(from[0], to[0]), y: Math.min(from[1], to[1]),
      width: Math.abs(to[0] - from[0]), height: Math.abs(to[1] - from[1]), visibility: "visible" })) {
      box.setAttribute(name, v);
    }
  });
  const end = (event) => {
    const start = from, to = point(event);
    from = null;
    box.setAttribute("visibility", "hidden");
    if (!start || [0, 1].some((i) => Math.abs(to[i] - start[i]) < SMALLEST_PX)) return;
    dragged = true;
    const [a, b] = [shares(start), shares(to)];
    show([Math.min(a[0], b[0]), Math.max(a[0], b[0]), Math.min(a[1], b[1]), Math.max(a[1], b[1])]);
  };
  svg.addEventListener("pointerup", end);
  svg.addEventListener("pointerleave", () => { from = null; box.setAttribute("visibility", "hidden"); });
  // A drawn box is not a click.
  svg.addEventListener("click", (event) => { if (dragged) event.stopPropagation(); dragged = false; });
  svg.addEventListener("dblclick", () => show(WHOLE));
  return { back, holds, key, shares: ([px, py]) => [(px - left) / width, 1 - (py - top) / height], variant };
};
