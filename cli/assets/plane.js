// Draws the planes of a page: root loci, pole-zero maps and Nyquist curves. Pointer and arrow keys read
// values, a drawn box zooms, and a double click resets the zoom. Live pages redraw with `feeler.plane`.
(() => {
  "use strict";
  const LEFT = 78, RIGHT = 18, TOP = 12, BOTTOM = 48;
  const REACH = 24;
  const INKS = ["first", "second", "third", "fourth", "fifth", "sixth"];
  const NS = "http://www.w3.org/2000/svg";
  const node = (name, attributes, text) => {
    const made = document.createElementNS(NS, name);
    for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
    if (text !== undefined) made.textContent = text;
    return made;
  };
  const short = (value) => Number(value.toPrecision(4)).toString().replace("-", "\u2212");
  const ticks = (low, high, most) => {
    const all = feeler.linearTicks(low, high, most, false), texts = feeler.tickTexts(all);
    return all.map((v, i) => [v, texts[i]]);
  };

  // The meaning of a point of the plane; `at` is a gain, or a frequency in Nyquist's plane.
  const reading = (plane, name, x, y, at) => {
    const parts = name ? [name] : [];
    if (plane.kind === "nyquist") {
      if (at != null) parts.push(`frequency ${short(at)} Hz`);
      parts.push(`modulus ${short(Math.hypot(x, y))}`, `phase ${short(Math.atan2(y, x) * 180 / Math.PI)}°`);
      return parts.join(" · ");
    }
    if (at != null) parts.push(`${plane.gain} = ${short(at)}`);
    let re = x, im = y * 2 * Math.PI;
    if (plane.period_s) {
      parts.push(`z = ${short(x)} ${y < 0 ? "\u2212" : "+"} ${short(Math.abs(y))}i`);
      [re, im] = [Math.log(Math.hypot(x, y)) / plane.period_s, Math.atan2(y, x) / plane.period_s];
    }
    const size = Math.hypot(re, im);
    if (Number.isFinite(size)) {
      parts.push(`s = ${short(re)} ${im < 0 ? "\u2212" : "+"} ${short(Math.abs(im))}i 1/s`,
          `frequency ${short(size / 2 / Math.PI)} Hz`);
      if (size > 0) parts.push(`damping ratio ${short(-re / size)}`);
    }
    return parts.join(" · ");
  };

  let planes = 0;
  const read = (plane) => {
    const path = (path) => ({ ...path, x: feeler.column(path.x), y: feeler.column(path.y),
        at: feeler.column(path.at) });
    return { ...plane, paths: plane.paths.map(path) };
  };
  feeler.plane = (place, written) => {
    let plane = read(written);
    // On a narrow screen the drawing has fewer units, so that text stays large. The inner rectangle keeps
    // its proportions.
    let WIDTH, HEIGHT;
    const svg = node("svg", { class: "plane-picture", role: "img",
        "aria-label": place.getAttribute("aria-label") || plane.x });
    const size = () => {
      const units = place.clientWidth < 640 ? [480, 251] : [900, 460];
      if (units[0] === WIDTH) return false;
      [WIDTH, HEIGHT] = units;
      svg.setAttribute("viewBox", `0 0 ${WIDTH} ${HEIGHT}`);
      return true;
    };
    size();
    const told = document.createElement("p");
    told.className = "told";
    told.setAttribute("aria-live", "polite");
    place.replaceChildren(svg, told);
    const number = planes++;
    let view = plane.view;
    const x = (v) => LEFT + (WIDTH - LEFT - RIGHT) * (v - view[0]) / (view[1] - view[0]);
    const y = (v) => TOP + (HEIGHT - TOP - BOTTOM) * (1 - (v - view[2]) / (view[3] - view[2]));
    const back = (px, py) => [
      view[0] + (px - LEFT) / (WIDTH - LEFT - RIGHT) * (view[1] - view[0]),
      view[3] - (py - TOP) / (HEIGHT - TOP - BOTTOM) * (view[3] - view[2]),
    ];
    const bounded = (v) => Math.max(-1e5, Math.min(1e5, v));
    const curve = (xs, ys, attributes) => {
      let pen = false;
      const d = Array.from(xs, (v, i) => {
        if (v == null || ys[i] == null) { pen = false; return ""; }
        const step = `${pen ? "L" : "M"}${bounded(x(v)).toFixed(1)} ${bounded(y(ys[i])).toFixed(1)}`;
        pen = true;
        return step;
      }).join("");
      return node("path", { d, fill: "none", ...attributes });
    };
    let spot, box;
    const paint = () => {
      svg.replaceChildren();
      const id = `clip-${number}`;
      const clip = node("clipPath", { id });
      clip.append(node("rect", { x: LEFT, y: TOP, width: WIDTH - LEFT - RIGHT,
          height: HEIGHT - TOP - BOTTOM }));
      svg.append(clip);
      for (const [v, label] of ticks(view[0], view[1], WIDTH / 110)) {
        svg.append(node("path", { d: `M${x(v)} ${TOP}V${HEIGHT - BOTTOM}`, class: "plane-grid" }));
        svg.append(node("text", { x: x(v), y: HEIGHT - BOTTOM + 17, "text-anchor": "middle",
            class: "plane-tick" }, label));
      }
      for (const [v, label] of ticks(view[2], view[3], HEIGHT / 62)) {
        svg.append(node("path", { d: `M${LEFT} ${y(v)}H${WIDTH - RIGHT}`, class: "plane-grid" }));
        svg.append(node("text", { x: LEFT - 7, y: y(v) + 4, "text-anchor": "end", class: "plane-tick" },
            label));
      }
      svg.append(node("text", { x: (LEFT + WIDTH - RIGHT) / 2, y: HEIGHT - 10, "text-anchor": "middle",
          class: "plane-label" }, plane.x));
      const middle = (TOP + HEIGHT - BOTTOM) / 2;
      svg.append(node("text", { x: 16, y: middle, "text-anchor": "middle",
          transform: `rotate(-90 16 ${middle})`, class: "plane-label" }, plane.y));
      const inner = node("g", { "clip-path": `url(#${id})` });
      svg.append(inner);
      const turn = Array.from({ length: 361 }, (_, i) => i * Math.PI / 180);
      for (const { centre, radius, kind, name } of plane.circles) {
        const drawn = curve(turn.map((a) => centre + radius * Math.cos(a)), turn.map((a) =>
            radius * Math.sin(a)), { class: `plane-${kind}` });
        drawn.append(node("title", {}, name));
        inner.append(drawn);
      }
      if (plane.kind === "nyquist") {
        inner.append(node("path", { d: `M${x(0)} ${TOP}V${HEIGHT - BOTTOM}M${LEFT} ${y(0)}H${WIDTH - RIGHT}`,
            class: "plane-grid" }));
      } else if (!plane.circles.length) {
        inner.append(node("path", { d: `M${x(0)} ${TOP}V${HEIGHT - BOTTOM}`, class: "plane-border" }));
      }
      plane.paths.forEach((path) => inner.append(curve(path.x, path.y, {
        class: `plane-path plane-colour-${path.colour}${path.dashed ? " plane-dashed" : ""}` })));
      for (const mark of plane.marks) {
        const px = x(mark.x), py = y(mark.y), own = mark.colour == null ? "" : " plane-own";
        const style = own && { style: `--own: var(--${INKS[mark.colour]})` };
        const kind = { class: `plane-mark plane-${mark.shape}${own}`, ...style };
        if (mark.shape === "pole") inner.append(node("path", { d: `M${px - 5} ${py - 5}l10 10m0 -10l-10 10`,
            ...kind }));
        else if (mark.shape === "now") inner.append(node("rect", { x: px - 4, y: py - 4, width: 8, height: 8,
            ...kind }));
        else inner.append(node("circle", { cx: px, cy: py, r: 5, ...kind }));
      }
      svg.append(node("rect", { x: LEFT, y: TOP, width: WIDTH - LEFT - RIGHT, height: HEIGHT - TOP - BOTTOM,
          class: "plane-frame" }));
      spot = node("circle", { r: 5, class: "plane-spot", visibility: "hidden" });
      box = node("rect", { class: "plane-box", visibility: "hidden" });
      svg.append(spot, box);
    };
    const rest = () => { spot.setAttribute("visibility", "hidden"); told.textContent = plane.hint; };
    const pointer = (event) => {
      const frame = svg.getBoundingClientRect(), scale = WIDTH / frame.width;
      return [(event.clientX - frame.left) * scale, (event.clientY - frame.top) * scale];
    };
    const show = ([vx, vy, name, at]) => {
      spot.setAttribute("cx", x(vx)); spot.setAttribute("cy", y(vy)); spot.setAttribute("visibility",
          "visible");
      told.textContent = reading(plane, name, vx, vy, at);
    };
    // Keys move along the visible points, curve by curve.
    const shown = () => {
      const all = [];
      const add = (vx, vy, name, at) => { if (vx != null && vx >= view[0] && vx <= view[1] && vy >= view[2] &&
          vy <= view[3]) all.push([vx, vy, name, at]); };
      plane.marks.forEach((mark) => add(mark.x, mark.y, mark.name, mark.at));
      plane.paths.forEach((path) => path.x.forEach((v, i) => add(v, path.y[i], path.name, path.at[i])));
      return all;
    };
    const zoom = (factor) => {
      const [cx, cy] = [(view[0] + view[1]) / 2, (view[2] + view[3]) / 2];
      view = [cx + factor * (view[0] - cx), cx + factor * (view[1] - cx), cy + factor * (view[2] - cy), cy +
          factor * (view[3] - cy)];
      paint(); rest();
    };
    let index = -1;
    place.onkeydown = (event) => {
      const go = (by) => { const all = shown(); if (all.length) {
        index = (index + by + all.length) % all.length; show(all[index]); } };
      const far = event.shiftKey ? 1 : 5;
      const acts = {
        ArrowRight: () => go(far), ArrowLeft: () => go(-far), "+": () => zoom(0.5), "=": () => zoom(0.5),
            "-": () => zoom(2),
        0: () => { view = plane.view; paint(); rest(); },
      };
      acts.Escape = acts[0];
      if (!acts[event.key] || event.ctrlKey || event.metaKey) return;
      acts[event.key]();
      event.preventDefault();
    };
    let from = null;
    svg.addEventListener("pointermove", (event) => {
      const [px, py] = pointer(event);
      if (from) {
        const [a, b] = [Math.min(from[0], px), Math.min(from[1], py)];
        for (const [key, value] of Object.entries({ x: a, y: b, width: Math.abs(px - from[0]),
            height: Math.abs(py - from[1]), visibility: "visible" })) box.setAttribute(key, value);
        return;
      }
      let best = null, least = REACH * REACH;
      const weigh = (vx, vy, found) => {
        if (vx == null || vy == null) return;
        const far = (x(vx) - px) ** 2 + (y(vy) - py) ** 2;
        if (far < least) { least = far; best = [vx, vy, ...found]; }
      };
      plane.paths.forEach((path) => path.x.forEach((v, i) => weigh(v, path.y[i], [path.name, path.at[i]])));
      plane.marks.forEach((mark) => weigh(mark.x, mark.y, [mark.name, mark.at]));
      if (!best) { rest(); return; }
      show(best);
    });
    svg.addEventListener("pointerdown", (event) => { from = pointer(event); });
    svg.addEventListener("pointerleave", () => { from = null; box.setAttribute("visibility", "hidden");
      rest(); });
    svg.addEventListener("pointerup", (event) => {
      const to = pointer(event), start = from;
      from = null;
      if (start && Math.abs(to[0] - start[0]) > 8 && Math.abs(to[1] - start[1]) > 8) {
        const [a, b] = [back(...start), back(...to)];
        view = [Math.min(a[0], b[0]), Math.max(a[0], b[0]), Math.min(a[1], b[1]), Math.max(a[1], b[1])];
      }
      paint(); rest();
    });
    svg.addEventListener("dblclick", () => { view = plane.view; paint(); rest(); });
    paint(); rest();
    new ResizeObserver(() => { if (size()) { paint(); rest(); } }).observe(place);
    // Shows new data of the same plane, with the same view.
    return { update: (next) => { const moved = view !== plane.view; plane = read(next);
      if (!moved) view = next.view; paint(); rest(); } };
  };
  const page = JSON.parse(document.getElementById("data").textContent);
  document.querySelectorAll(".plane[data-plane]").forEach((place) => feeler.plane(place,
      page.planes[place.dataset.plane]));
})();
