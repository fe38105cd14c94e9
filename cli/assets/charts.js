// Draws charts with uPlot from data; pointer and keys read values and zoom, and a chart can be saved. Live
// pages redraw with `feeler.chart`.
const feeler = (() => {
  "use strict";
  // Okabe and Ito's colours, distinct for all types of colour vision. Their order depends on the
  // background, so that the first ones have the best contrast.
  const ON_LIGHT = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#56b4e9", "#e69f00"];
  const ON_DARK = ["#56b4e9", "#e69f00", "#009e73", "#cc79a7", "#f0e442", "#d55e00"];
  const HEIGHT = 280, PATH_HEIGHT = 420;
  const FONT = "12px system-ui, sans-serif";
  // A difference below this share of the values is a rounding error, and so is one below these bounds: for
  // levels in dB and angles in degrees, and for numbers in any other unit.
  const ROUNDING = 1e-10, NO_LEVEL = 1e-6, NOTHING = 1e-12;
  const nothing = (label) => /\((dB|°)\)$/.test(label) ? NO_LEVEL : NOTHING;
  const root = document.documentElement;
  const scheme = matchMedia("(prefers-color-scheme: dark)");
  const dark = () => scheme.matches && !root.classList.contains("print");
  // Requesting computed styles while drawing would lay out the page each time.
  const colours = new Map();
  const colour = (name) => {
    const key = `${name} ${dark()}`;
    if (!colours.has(key)) colours.set(key, getComputedStyle(root).getPropertyValue(name).trim());
    return colours.get(key);
  };
  const palette = (i) => { const inks = dark() ? ON_DARK : ON_LIGHT; return inks[i % inks.length]; };
  const text = () => colour("--text"), soft = () => colour("--soft"), grid = () => colour("--line");
  const short = (value) => value == null ? "" : Number(value.toPrecision(5)).toString();

  const bytes = (encoded) => {
    const raw = atob(encoded), out = new Uint8Array(raw.length);
    for (let i = 0; i < raw.length; i++) out[i] = raw.charCodeAt(i);
    return out.buffer;
  };
  // uPlot needs `null` for a gap.
  const gaps = (values) => values.every(Number.isFinite) ? values : Array.from(values, (v) =>
      Number.isFinite(v) ? v : null);
  // Reads values in one of the forms of a page: a list, the bytes of floats, or even steps.
  const column = (values) => {
    if (Array.isArray(values)) return values;
    if (values.f32) return gaps(new Float32Array(bytes(values.f32)));
    if (values.f64) return gaps(new Float64Array(bytes(values.f64)));
    return Float64Array.from({ length: values.count }, (_, i) => values.from + i * values.step);
  };

  const linearTicks = (low, high, most, angle, least = 0) => {
    const rough = (high - low) / Math.max(most, 1), power = 10 ** Math.floor(Math.log10(rough));
    const steps = angle && rough > 1 ? [5, 15, 45, 90, 180, 360, 720, 1440, 3600] : [1, 2, 5, 10].map((m) =>
        m * power);
    const k = steps.findIndex((s) => s >= rough * (1 - 1e-9)), chosen = steps[k] ?? rough;
    const ticks = (step) => {
      const all = [];
      for (let i = Math.ceil(low / step - 1e-9); i * step <= high + 1e-9 * step && all.length < 100;
        i++) all.push(i * step);
      return all;
    };
    const all = ticks(chosen);
    return all.length < least ? ticks(steps[k - 1] ?? chosen / 2) : all;
  };
  const logTicks = (low, high, most) => {
    if (!(low > 0) || !(high > low)) return [];
    const decades = Math.log10(high / low);
    if (decades < 0.7) return linearTicks(low, high, most, false);
    const of = decades < 2.5 ? [1, 2, 5] : [1], step = Math.max(1, Math.ceil(decades / Math.max(most, 2)));
    const all = [];
    for (let e = step * Math.floor(Math.log10(low) / step); e <= Math.log10(high); e += step) {
      for (const m of of) {
        const v = Number(`${m}e${e}`);
        if (v >= low * (1 - 1e-9) && v <= high * (1 + 1e-9)) all.push(v);
      }
    }
    return all;
  };
  // Neighbouring ticks have as many digits as they need to differ.
  const tickTexts = (ticks) => {
    const largest = ticks.reduce((m, v) => Math.max(m, Math.abs(v)), 0);
    const least = ticks.slice(1).reduce((m, v, i) => Math.min(m, Math.abs(v - ticks[i])), Infinity);
    const digits = Number.isFinite(least) && least > 0 ? Math.min(15,
        Math.max(1, Math.ceil(Math.log10(largest / least)) + 1)) : 5;
    return ticks.map((v) => {
      const shown = Number(v.toPrecision(digits)), size = Math.abs(shown);
      const written = shown !== 0 && (size >= 1e6 || size < 1e-4) ? shown.toExponential().replace("e+", "e") :
          shown.toString();
      return written.replace("-", "\u2212");
    });
  };

  // The ticks are computed here, because uPlot's search for steps fails below 1e-16 and may loop forever.
  const axis = (label, side, log) => ({
    label, side, font: FONT, labelFont: FONT, stroke: soft, labelSize: 22, labelGap: 2,
    grid: { stroke: grid, width: 1 }, ticks: { stroke: grid, width: 1, size: 5 },
    incrs: (u, i, low, high) => [Math.max(5, high - low)],
    splits: (u, i, low, high) => {
      const most = (side === 3 ? u.bbox.height / 46 : u.bbox.width / 90) / devicePixelRatio;
      // A single tick does not show a scale.
      return log ? logTicks(low, high, most) : linearTicks(low, high, most, /\(°\)/.test(label),
          side === 3 ? 3 : 0);
    },
    // uPlot would drop all ticks of a logarithmic axis but the decades.
    filter: (u, splits) => splits,
    values: (u, splits) => tickTexts(splits),
    // All axes have the same width, so that times align.
    size: side === 3 ? 76 : 32,
  });

  // Shaded spans behind the curves.
  const shade = (chart) => (u) => {
    const { ctx } = u, { left, top, width, height } = u.bbox;
    ctx.save();
    ctx.beginPath(); ctx.rect(left, top, width, height); ctx.clip();
    ctx.fillStyle = colour("--shade");
    for (const [from, to] of chart.bands) {
      const a = u.valToPos(from, "x", true), b = u.valToPos(to, "x", true);
      if (b >= left && a <= left + width) ctx.fillRect(a, top, Math.max(b - a, 0.5), height);
    }
    ctx.restore();
  };

  // Named lines, spans and points over the curves. Names keep away from the edges.
  const annotate = (chart) => (u) => {
    const { ctx } = u, { left, top, width, height } = u.bbox, scale = devicePixelRatio;
    const at = (x, y) => [u.valToPos(x, "x", true), u.valToPos(y, "y", true)];
    ctx.save();
    ctx.beginPath(); ctx.rect(left, top, width, height); ctx.clip();
    ctx.font = `${12 * scale}px system-ui, sans-serif`;
    ctx.textAlign = "left"; ctx.textBaseline = "alphabetic";
    ctx.fillStyle = text(); ctx.strokeStyle = soft(); ctx.lineWidth = scale;
    const named = [];
    const name = (label, x, wanted) => {
      const w = ctx.measureText(label).width, row = 15 * scale;
      const from = Math.min(Math.max(x, left + 4 * scale), left + width - w - 4 * scale);
      // A name is above other names, or below them at the upper edge.
      let y = wanted, way = -row;
      const meets = ([a, b, at]) => from < b && from + w > a && Math.abs(y - at) < row;
      for (let hit = named.find(meets); hit; hit = named.find(meets)) {
        if (hit[2] + way < top + 9 * scale) way = row;
        y = hit[2] + way;
      }
      named.push([from, from + w, y]);
      ctx.save();
      ctx.globalAlpha = 0.8; ctx.fillStyle = colour("--ground");
      ctx.fillRect(from - 2 * scale, y - 12 * scale, w + 4 * scale, 15 * scale);
      ctx.restore();
      ctx.fillText(label, from, y);
    };
    for (const line of chart.lines) {
      const y = u.valToPos(line.y, "y", true);
      if (y < top || y > top + height) continue;
      ctx.setLineDash([6 * scale, 4 * scale]);
      ctx.beginPath(); ctx.moveTo(left, y); ctx.lineTo(left + width, y); ctx.stroke();
      name(line.label, left + 8 * scale, y < top + 20 * scale ? y + 14 * scale : y - 5 * scale);
    }
    ctx.setLineDash([]);
    for (const gauge of chart.gauges ?? []) {
      const [x, from] = at(gauge.x, gauge.from), [, to] = at(gauge.x, gauge.to);
      if (x < left || x > left + width) continue;
      ctx.save();
      ctx.strokeStyle = ctx.fillStyle = palette(1); ctx.lineWidth = 2.5 * scale;
      ctx.beginPath(); ctx.moveTo(x, from); ctx.lineTo(x, to);
      for (const y of [from, to]) { ctx.moveTo(x - 5 * scale, y); ctx.lineTo(x + 5 * scale, y); }
      ctx.stroke();
      ctx.restore();
      name(gauge.label, x + 8 * scale, Math.min(Math.max((from + to) / 2, top + 16 * scale), top +
          height - 8 * scale));
    }
    for (const mark of chart.marks) {
      const [x, y] = at(mark.x, mark.y);
      if (x < left || x > left + width) continue;
      ctx.beginPath(); ctx.arc(x, y, 4 * scale, 0, 2 * Math.PI); ctx.stroke();
      name(mark.label, x + 8 * scale, Math.max(y - 6 * scale, top + 14 * scale));
    }
    ctx.restore();
  };

  // Single points have no area between them, so a bar joins each pair.
  const isBars = (chart) => ([upper]) => chart.series[upper].dots;
  const bars = (chart) => (u) => {
    const { ctx } = u, { left, top, width, height } = u.bbox;
    for (const [upper, lower] of (chart.between ?? []).filter(isBars(chart))) {
      ctx.save();
      ctx.beginPath(); ctx.rect(left, top, width, height); ctx.clip();
      ctx.strokeStyle = palette(chart.series[upper].colour ?? upper);
      ctx.globalAlpha = 0.55; ctx.lineWidth = 1.5 * devicePixelRatio;
      ctx.beginPath();
      Array.from(u.data[0]).forEach((x, i) => {
        const ends = [upper, lower].map((k) => u.data[k + 1][i]);
        if (ends.some((end) => end == null)) return;
        const [px, high, low] = [u.valToPos(x, "x", true), ...ends.map((y) => u.valToPos(y, "y", true))];
        ctx.moveTo(px, high); ctx.lineTo(px, low);
      });
      ctx.stroke();
      ctx.restore();
    }
  };

  // The vertical range includes named lines. A difference that is a rounding error does not fill a chart.
  const vertical = (chart) => chart.y.log
    ? { distr: 3, log: 10, range: (u, low, high) => low == null ? [0.1, 1] : high > low ? [low / 1.3,
        high * 1.3] : [low / 10, high * 10] }
    : {
      range: (u, low, high) => {
        if (low == null) return [0, 1];
        for (const line of chart.lines) { low = Math.min(low, line.y); high = Math.max(high, line.y); }
        if (chart.y.least != null) low = Math.max(low, Math.min(chart.y.least, high - 1));
        const size = Math.max(Math.abs(low), Math.abs(high)), least = nothing(chart.y.label);
        const room = high - low > Math.max(ROUNDING * size, least) ? 0.06 * (high - low) :
            size > least ? 0.5 * size : 1;
        return [low - room, high + room];
      },
    };

  // Range of the values, shown while the pointer is over no value.
  const span = (values) => {
    let low = Infinity, high = -Infinity;
    for (const v of values) if (v != null) { if (v < low) low = v; if (v > high) high = v; }
    return low <= high ? `${short(low)} to ${short(high)}` : "";
  };
  // Ranges of the present data, because a live page replaces the data.
  const spans = new WeakMap();
  const spanOf = (values) => spans.get(values) ?? (spans.set(values, span(values)), spans.get(values));

  const curves = (chart) => chart.series.map((series, i) => {
    const paint = series.measured ? soft() : palette(series.colour ?? i);
    return {
      label: series.name + (series.unit ? ` (${series.unit})` : ""), stroke: paint,
      width: series.measured ? 3.5 : series.dashed ? 1.5 : series.faint ? 1 : 1.4,
      alpha: series.faint || series.measured ? 0.55 : 1,
      dash: series.dashed ? [7, 4] : undefined, value: (u, v, index) => v == null ?
          spanOf(chart.kind === "path" ? u.data[index][1] : u.data[index]) : short(v),
      ...(series.dots ? { paths: () => null, points: { show: true, size: i === 0 ? 6 : 4, width: 1,
          fill: paint } } : { points: { show: false } }),
    };
  });

  // The instant under the pointer on a time chart, for a scene on the same page.
  const point = (chart) => (u) => {
    const { idx, left } = u.cursor;
    if (!chart.x.together || idx == null || left < 0) return;
    document.dispatchEvent(new CustomEvent("feeler:chart", { detail: u.data[0][idx] }));
  };

  const columns = (chart) => [column(chart.x.values), ...chart.series.map((series) => column(series.values))];
  const lineChart = (chart, width) => {
    const data = columns(chart);
    const extent = (xs) => xs[xs.length - 1] > xs[0] ? [xs[0], xs[xs.length - 1]] : [(xs[0] ?? 0) - 1,
        (xs[0] ?? 0) + 1];
    const options = {
      width, height: chart.height ?? HEIGHT, padding: [12, 18, 0, 4],
      cursor: { drag: { x: true, y: false }, ...(chart.x.together ? { sync: { key: chart.x.together } } :
          {}) },
      scales: {
        x: { time: false, ...(chart.x.log ? { distr: 3, log: 10 } : {}), range: (u, low, high) =>
            low == null || low === high ? extent(u.data[0]) : [low, high] },
        y: vertical(chart),
      },
      axes: [axis(chart.x.label, 2, chart.x.log), axis(chart.y.label, 3, chart.y.log)],
      series: [{ label: chart.x.label, value: (u, v) => v == null ? span(u.data[0]) :
          Number(v.toPrecision(8)).toString() }, ...curves(chart)],
      bands: (chart.between ?? []).filter((pair) => !isBars(chart)(pair)).map(([upper, lower]) =>
          ({ series: [upper + 1, lower + 1], fill: colour("--shade") })),
      hooks: { drawClear: [shade(chart)], draw: [bars(chart), annotate(chart)], setCursor: [point(chart)] },
    };
    const reset = (u) => { const [min, max] = extent(u.data[0]); u.setScale("x", { min, max }); };
    return [options, data, reset];
  };

  // Each series is a separate path. The pointer selects the nearest point of the first.
  const pathChart = (chart, width) => {
    const own = column(chart.x.values), paths = chart.series.map((series) => [own, column(series.values)]);
    const path = (u, index) => {
      const drawn = new Path2D();
      const [xs, ys] = u.data[index];
      xs.forEach((x, i) => {
        const px = u.valToPos(x, "x", true), py = u.valToPos(ys[i], "y", true);
        if (i === 0) drawn.moveTo(px, py); else drawn.lineTo(px, py);
      });
      return { stroke: drawn, fill: null, clip: null, flags: 1 };
    };
    const nearest = (u) => {
      const [xs, ys] = u.data[1];
      let best = null, least = 30 * 30;
      xs.forEach((x, i) => {
        const dx = u.valToPos(x, "x") - u.cursor.left, dy = u.valToPos(ys[i], "y") - u.cursor.top,
            far = dx * dx + dy * dy;
        if (far < least) { least = far; best = i; }
      });
      return best;
    };
    const extent = (all) => {
      let low = Infinity, high = -Infinity;
      for (const values of all) for (const v of values) if (v != null) { low = Math.min(low, v);
        high = Math.max(high, v); }
      const size = Math.max(Math.abs(low), Math.abs(high));
      const room = high - low > ROUNDING * size ? 0.05 * (high - low) : 0.5 * size || 1;
      return [low - room, high + room];
    };
    const xs = extent([own]), ys = extent(paths.map((pair) => pair[1]));
    const options = {
      mode: 2, width, height: PATH_HEIGHT, padding: [12, 18, 0, 4],
      cursor: { drag: { x: true, y: true, uni: 20 }, dataIdx: nearest, points: { size: 7 } },
      scales: { x: { time: false, auto: false, range: (u, low, high) => low == null || low === high ? xs :
          [low, high] },
                y: { auto: false, range: (u, low, high) => low == null || low === high ? ys : [low, high] } },
      axes: [axis(chart.x.label, 2, false), axis(chart.y.label, 3, false)],
      series: [{}, ...curves(chart).map((curve) => ({
        ...curve, paths: path, facets: [{ scale: "x", auto: false }, { scale: "y", auto: false }],
        value: (u, v, index, i) => i == null ? span(u.data[index][1]) :
            `${short(u.data[index][0][i])}, ${short(u.data[index][1][i])}`,
      }))],
      hooks: { draw: [annotate(chart)], ready: [(u) => u.over.addEventListener("dblclick", () => reset(u))] },
    };
    const reset = (u) => u.batch(() => { u.setScale("x", { min: xs[0], max: xs[1] });
      u.setScale("y", { min: ys[0], max: ys[1] }); });
    return [options, [null, ...paths], reset, true];
  };

  // Arrow keys move the cursor, + and − zoom about it, and 0 shows the whole range.
  const keys = (place, u, reset) => {
    let point = -1;
    place.onkeydown = (event) => {
      const width = u.over.clientWidth, at = u.cursor.left >= 0 ? u.cursor.left : width / 2;
      const move = (by) => {
        if (u.mode !== 2) { u.setCursor({ left: Math.min(Math.max(at + by, 0), width - 1),
            top: u.over.clientHeight / 2 }); return; }
        // On a path the keys move from point to point.
        const [xs, ys] = u.data[1], steps = event.shiftKey ? 1 : Math.ceil(xs.length / 50);
        point = Math.min(Math.max(point + Math.sign(by) * steps, 0), xs.length - 1);
        u.setCursor({ left: u.valToPos(xs[point], "x"), top: u.valToPos(ys[point], "y") });
      };
      const log = u.scales.x.distr === 3;
      const zoom = (factor) => {
        const { min, max } = u.scales.x, to = log ? Math.log : (v) => v, from = log ? Math.exp : (v) => v;
        const centre = to(u.posToVal(at, "x"));
        u.setScale("x", { min: from(centre + factor * (to(min) - centre)), max: from(centre +
            factor * (to(max) - centre)) });
      };
      const fine = event.shiftKey ? 1 : width / 50;
      const acts = {
        ArrowLeft: () => move(-fine), ArrowRight: () => move(fine),
        "+": () => zoom(0.5), "=": () => zoom(0.5), "-": () => zoom(2), 0: () => reset(u), Escape: () =>
            reset(u),
      };
      if (!acts[event.key] || event.ctrlKey || event.metaKey) return;
      acts[event.key]();
      event.preventDefault();
    };
  };

  const offer = (name, blob) => {
    const link = document.createElement("a");
    link.href = URL.createObjectURL(blob);
    link.download = name;
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 1000);
  };
  const quoted = (word) => `"${String(word).replaceAll('"', '""')}"`;
  // A table of the values of a chart, and an image of the chart.
  const csv = (chart) => {
    const all = columns(chart);
    const head = [chart.x.label, ...chart.series.map((series) => series.name +
        (series.unit ? ` (${series.unit})` : ""))].map(quoted).join(",");
    return [head, ...Array.from(all[0], (_, i) => all.map((values) =>
        values[i] ?? "").join(","))].join("\n") + "\n";
  };
  const save = (place, chart) => {
    const name = (place.getAttribute("aria-label") || "chart").replace(/[^A-Za-z0-9]+/g,
        "-").replace(/^-|-$/g, "").toLowerCase();
    const row = document.createElement("div");
    row.className = "save";
    const button = (label, act) => {
      const made = document.createElement("button");
      made.type = "button"; made.textContent = label;
      made.setAttribute("aria-label", `Save ${name} as ${label}`);
      made.onclick = act;
      row.append(made);
    };
    button("CSV", () => offer(`${name}.csv`, new Blob([csv(chart)], { type: "text/csv" })));
    button("PNG", () => place.querySelector("canvas").toBlob((blob) => offer(`${name}.png`, blob)));
    place.append(row);
  };

  // Draws one chart. An error in one chart does not affect the others.
  const draw = (place, chart, { width, saves = true } = {}) => {
    try {
      const [options, data, reset, begin] = (chart.kind === "path" ? pathChart : lineChart)(chart, width ||
          place.clientWidth);
      place.replaceChildren();
      const u = new uPlot(options, data, place);
      if (begin) reset(u);
      u.together = chart.x.together;
      const canvas = place.querySelector("canvas");
      canvas.setAttribute("role", "img");
      canvas.setAttribute("aria-label", place.getAttribute("aria-label") || chart.y.label);
      keys(place, u, reset);
      if (saves) save(place, chart);
      return u;
    } catch (error) {
      place.textContent = `This chart could not be drawn (${error.message}).`;
      return null;
    }
  };
  // Replaces the data of a line chart. The drawing code reads the chart object, so it is changed in place.
  // The zoom is kept.
  const update = (u, chart, next) => {
    const xs = u.data[0], { min, max } = u.scales.x, zoomed = min > xs[0] || max < xs[xs.length - 1];
    Object.assign(chart, next);
    u.setData(columns(chart), !zoomed);
    if (zoomed) u.setScale("x", { min, max });
  };
  return { draw, update, column, palette, dark, linearTicks, logTicks, tickTexts };
})();
