// Draws the charts of a page from the data that it carries.
(() => {
  "use strict";
  const page = JSON.parse(document.getElementById("data").textContent);
  // Okabe and Ito's colours, told apart by all kinds of sight, in the order that stands out on light or on dark ground.
  const ON_LIGHT = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#56b4e9", "#e69f00"];
  const ON_DARK = ["#56b4e9", "#e69f00", "#009e73", "#cc79a7", "#f0e442", "#d55e00"];
  const HEIGHT = 280, PATH_HEIGHT = 420, PRINT_WIDTH = 680;
  const FONT = "12px system-ui, sans-serif";
  const colour = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();
  const dark = () => matchMedia("(prefers-color-scheme: dark)").matches && !document.documentElement.classList.contains("print");
  const palette = (i) => { const colours = dark() ? ON_DARK : ON_LIGHT; return colours[i % colours.length]; };
  const text = () => colour("--text"), soft = () => colour("--soft"), grid = () => colour("--line");
  const short = (value) => value == null ? "" : Number(value.toPrecision(5)).toString();

  // Lines at decades alone; an amplitude may span many.
  const decades = (u, splits) => splits.map((v) => v != null && isDecade(v) ? v : null);
  const axis = (label, side, log) => ({
    label, side, font: FONT, labelFont: FONT, stroke: soft, labelSize: 22, labelGap: 2,
    grid: { stroke: grid, width: 1, ...(log && side === 3 ? { filter: decades } : {}) }, ticks: { stroke: grid, width: 1, size: 5 },
    values: (u, splits) => splits.map((v) => v == null ? "" : log && !isDecade(v) ? "" : short(v)),
    // Angles are read in parts of a turn.
    ...(/\(°\)/.test(label) ? { incrs: [1, 5, 15, 45, 90, 180, 360, 720, 1440, 3600] } : {}),
    // One width for all, so that times stand below each other.
    size: side === 3 ? 76 : 32,
  });
  const isDecade = (v) => { const e = Math.log10(v); return Math.abs(e - Math.round(e)) < 1e-6; };

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

  // Named lines and points over the curves; names keep clear of each other and of the edges.
  const annotate = (chart) => (u) => {
    const { ctx } = u, { left, top, width, height } = u.bbox, scale = devicePixelRatio;
    ctx.save();
    ctx.beginPath(); ctx.rect(left, top, width, height); ctx.clip();
    ctx.font = `${12 * scale}px system-ui, sans-serif`;
    ctx.textAlign = "left"; ctx.textBaseline = "alphabetic";
    ctx.fillStyle = text(); ctx.strokeStyle = soft(); ctx.lineWidth = scale;
    const name = (label, x, y) => {
      const w = ctx.measureText(label).width;
      const at = Math.min(Math.max(x, left + 4 * scale), left + width - w - 4 * scale);
      ctx.save();
      ctx.globalAlpha = 0.8; ctx.fillStyle = colour("--ground");
      ctx.fillRect(at - 2 * scale, y - 12 * scale, w + 4 * scale, 15 * scale);
      ctx.restore();
      ctx.fillText(label, at, y);
    };
    for (const line of chart.lines) {
      const y = u.valToPos(line.y, "y", true);
      if (y < top || y > top + height) continue;
      ctx.setLineDash([6 * scale, 4 * scale]);
      ctx.beginPath(); ctx.moveTo(left, y); ctx.lineTo(left + width, y); ctx.stroke();
      name(line.label, left + 8 * scale, y < top + 20 * scale ? y + 14 * scale : y - 5 * scale);
    }
    ctx.setLineDash([]);
    for (const mark of chart.marks) {
      const x = u.valToPos(mark.x, "x", true), y = u.valToPos(mark.y, "y", true);
      if (x < left || x > left + width) continue;
      ctx.beginPath(); ctx.arc(x, y, 4 * scale, 0, 2 * Math.PI); ctx.stroke();
      name(mark.label, x + 8 * scale, Math.max(y - 6 * scale, top + 14 * scale));
    }
    ctx.restore();
  };

  // Room for named lines within the vertical range.
  const vertical = (chart) => chart.y.log ? { distr: 3, log: 10 } : {
    range: (u, low, high) => {
      if (low == null) return [0, 1];
      for (const line of chart.lines) { low = Math.min(low, line.y); high = Math.max(high, line.y); }
      const room = 0.06 * (high - low || Math.abs(high) || 1);
      return [low - room, high + room];
    },
  };

  // Shown while no value is pointed at.
  const spans = new Map();
  const span = (values) => {
    if (!spans.has(values)) {
      const known = values.filter((v) => v != null);
      const [low, high] = [known.reduce((a, b) => Math.min(a, b), Infinity), known.reduce((a, b) => Math.max(a, b), -Infinity)];
      spans.set(values, known.length ? `${short(low)} to ${short(high)}` : "");
    }
    return spans.get(values);
  };

  const curves = (chart) => chart.series.map((series, i) => ({
    label: series.name + (series.unit ? ` (${series.unit})` : ""), stroke: palette(i), width: series.dashed ? 1.5 : 1.3,
    dash: series.dashed ? [7, 4] : undefined, value: (u, v) => v == null ? span(series.values) : short(v),
    ...(series.dots ? { paths: () => null, points: { show: true, size: i === 0 ? 6 : 4, width: 1, fill: palette(i) } } : { points: { show: false } }),
  }));

  const lineChart = (chart, width) => {
    const options = {
      width, height: HEIGHT, padding: [12, 18, 0, 4],
      cursor: { drag: { x: true, y: false }, ...(chart.x.together ? { sync: { key: chart.x.together } } : {}) },
      scales: { x: { time: false, ...(chart.x.log ? { distr: 3, log: 10, range: (u, low, high) => [low, high] } : {}) }, y: vertical(chart) },
      axes: [axis(chart.x.label, 2, chart.x.log), axis(chart.y.label, 3, chart.y.log)],
      series: [{ label: chart.x.label, value: (u, v) => v == null ? span(chart.x.values) : Number(v.toPrecision(8)).toString() }, ...curves(chart)],
      hooks: { drawClear: [shade(chart)], draw: [annotate(chart)] },
    };
    return [options, [chart.x.values, ...chart.series.map((series) => series.values)]];
  };

  // Each series is a path of its own; the pointer picks the nearest point of the first.
  const pathChart = (chart, width) => {
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
        const dx = u.valToPos(x, "x") - u.cursor.left, dy = u.valToPos(ys[i], "y") - u.cursor.top, far = dx * dx + dy * dy;
        if (far < least) { least = far; best = i; }
      });
      return best;
    };
    const room = (low, high) => { const r = 0.05 * (high - low || 1); return [low - r, high + r]; };
    const extent = (which) => {
      const all = chart.series.map((series) => which === 0 ? chart.x.values : series.values).flat();
      return room(all.reduce((a, b) => Math.min(a, b), Infinity), all.reduce((a, b) => Math.max(a, b), -Infinity));
    };
    const [xs, ys] = [extent(0), extent(1)];
    const options = {
      mode: 2, width, height: PATH_HEIGHT, padding: [12, 18, 0, 4],
      cursor: { drag: { x: true, y: true, uni: 20 }, dataIdx: nearest, points: { size: 7 } },
      scales: { x: { time: false, auto: false, range: (u, low, high) => low == null || low === high ? xs : [low, high] },
                y: { auto: false, range: (u, low, high) => low == null || low === high ? ys : [low, high] } },
      axes: [axis(chart.x.label, 2, false), axis(chart.y.label, 3, false)],
      series: [{}, ...curves(chart).map((curve) => ({
        ...curve, paths: path, facets: [{ scale: "x", auto: false }, { scale: "y", auto: false }],
        value: (u, v, index, i) => i == null ? span(u.data[index][1]) : `${short(u.data[index][0][i])}, ${short(u.data[index][1][i])}`,
      }))],
      hooks: {
        draw: [annotate(chart)],
        ready: [(u) => u.over.addEventListener("dblclick", () => reset(u))],
      },
    };
    const reset = (u) => u.batch(() => { u.setScale("x", { min: xs[0], max: xs[1] }); u.setScale("y", { min: ys[0], max: ys[1] }); });
    const data = [null, ...chart.series.map((series) => [chart.x.values, series.values])];
    return [options, data, reset];
  };

  let drawn = [];
  const draw = (fixed) => {
    drawn.forEach((u) => u.destroy());
    drawn = [...document.querySelectorAll(".chart")].map((place) => {
      const chart = page.charts[place.dataset.chart];
      const [options, data, begin] = (chart.kind === "path" ? pathChart : lineChart)(chart, fixed || place.clientWidth);
      const u = new uPlot(options, data, place);
      if (begin) begin(u);
      return u;
    });
  };
  draw();
  let waiting;
  const widths = () => drawn.forEach((u) => u.setSize({ width: u.root.parentNode.clientWidth, height: u.height }));
  window.addEventListener("resize", () => { clearTimeout(waiting); waiting = setTimeout(widths, 100); });
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => draw());
  window.addEventListener("beforeprint", () => { document.documentElement.classList.add("print"); draw(PRINT_WIDTH); });
  window.addEventListener("afterprint", () => { document.documentElement.classList.remove("print"); draw(); });
})();
