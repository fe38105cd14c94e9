// A live page: sliders request run and theory from the command. Each has one request at a time, and the
// latest setting comes first.
(() => {
  "use strict";
  const data = JSON.parse(document.getElementById("data").textContent);
  const $ = (id) => document.getElementById(id);
  const make = (name, set, ...inside) => { const made = Object.assign(document.createElement(name), set);
    made.append(...inside); return made; };
  const node = (name, attributes, text) => {
    const made = document.createElementNS("http://www.w3.org/2000/svg", name);
    for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
    if (text !== undefined) made.textContent = text;
    return made;
  };
  // Shows text between backticks as code.
  const prose = (place, text) => place.replaceChildren(...text.split("`").map((part, i, parts) =>
      i % 2 && i + 1 < parts.length ? make("code", { textContent: part }) : part));
  const short = (v, digits = 4) => Number(v.toPrecision(digits)).toString();
  const post = async (path, body) => {
    try {
      return await (await fetch(path, { method: "POST", body: JSON.stringify(body) })).json();
    } catch {
      return { problem: "The command that serves this page has ended." };
    }
  };
  const STEPS = 1000, REACH = 10, LATENCIES = 400;
  // A slider is at rest if it has not moved for this time, ms.
  const REST_MS = 100;
  // Figures that belong to each part of a state.
  const PARTS = { run: ["force", "drive"], theory: ["step", "magnitude", "phase", "nyquist", "locus"] };
  const knobs = new Map(), answers = {};
  let version = 0, pinned = null, mistake = "", lastMove = 0;

  // Sliders of positive numbers have a ratio scale, others a linear one; zero has a separate range.
  const scale = (value) => value > 0 ? { low: value / REACH, high: value * REACH, log: true }
    : value < 0 ? { low: value * 2, high: 0, log: false } : { low: 0, high: 1, log: false };
  const share = ({ low, high, log }, v) => log ? Math.log(v / low) / Math.log(high / low) :
      (v - low) / (high - low);
  const value = ({ low, high, log }, s) => log ? low * (high / low) ** s : low + s * (high - low);
  const settings = () => Object.fromEntries([...knobs].filter(([, knob]) =>
      knob.value !== knob.file).map(([key, knob]) => [key, knob.value]));

  const show = (knob) => {
    knob.slider.value = Math.round(STEPS * share(knob.range, knob.value));
    knob.number.value = short(knob.value, 6);
    knob.row.classList.toggle("moved", knob.value !== knob.file);
  };
  const set = (key, v) => {
    const knob = knobs.get(key);
    if (!knob || !Number.isFinite(v)) return;
    knob.value = v;
    if (v < knob.range.low || v > knob.range.high) knob.range = { ...scale(v), low: Math.min(scale(v).low,
        knob.range.low), high: Math.max(scale(v).high, knob.range.high) };
    if (knob.range.log && knob.range.low <= 0) knob.range = { low: Math.min(0, v),
        high: Math.max(knob.range.high, v), log: false };
    show(knob);
  };
  const remember = () => {
    const moved = new URLSearchParams(Object.entries(settings()).map(([key, v]) => [key,
        String(v)])).toString();
    history.replaceState(null, "", moved ? `#${moved}` : location.pathname);
  };
  const moved = (key, v) => { lastMove = performance.now(); set(key, v); ask(); };

  const knob = ({ key, value: v, unit }) => {
    const id = `knob-${key}`, name = key.split(".").slice(2).join(".") || key;
    const label = make("label", { htmlFor: id, textContent: name, title: key });
    const number = make("input", { type: "number", step: "any" });
    number.setAttribute("aria-label", `${key} in SI`);
    const slider = make("input", { type: "range", min: 0, max: STEPS, step: 1, id });
    const row = make("div", { className: "knob" }, label, number, make("span", { textContent: unit }),
        slider);
    const made = { key, value: v, file: v, range: scale(v), slider, number, row, unit };
    slider.oninput = () => moved(key, Number(short(value(made.range, slider.value / STEPS), 4)));
    number.onchange = () => moved(key, Number(number.value));
    knobs.set(key, made);
    show(made);
    return row;
  };

  // Entries of a list are in a fold of their own, which is open if there are few.
  const FEW = 6;
  const build = (file) => {
    const kept = settings(), folds = [...$("knobs").querySelectorAll("details")];
    const opened = new Map(folds.map((fold) => [fold.of, fold.open]));
    knobs.clear();
    const groups = new Map(), lists = new Map();
    for (const number of file.numbers) {
      const [table, name] = number.key.split(".");
      const group = `${table}.${name}`, list = number.key.match(/^(?:[^.]+\.){2}(.+?)(?:\.\d+)+$/)?.[1];
      if (!groups.has(group)) groups.set(group, []);
      const rows = groups.get(group), of = `${group}.${list}`;
      if (list && !lists.has(of)) {
        lists.set(of, make("details", { of }, make("summary", { textContent: list })));
        rows.push(lists.get(of));
      }
      if (list) lists.get(of).append(knob(number)); else rows.push(knob(number));
    }
    for (const [of, fold] of lists) fold.open = opened.get(of) ?? fold.children.length <= FEW + 1;
    const first = [...groups].sort((a, b) => rank(a[0]) - rank(b[0]));
    const folded = first.map(([group, rows]) => make("details", { of: group,
      open: opened.get(group) ?? rank(group) < 2 }, make("summary", { textContent: group }), ...rows));
    $("knobs").replaceChildren(acts, told, ...folded);
    for (const [key, v] of Object.entries(kept)) set(key, v);
  };
  const FIRST = ["controllers", "contacts", "springs", "sensors", "actuators"];
  const rank = (group) => {
    const found = FIRST.indexOf(group.split(".")[0]);
    return found < 0 ? FIRST.length : found;
  };

  const told = make("p", { id: "told" });
  told.setAttribute("aria-live", "polite");
  const button = (text, act) => make("button", { type: "button", textContent: text, onclick: act });
  const pin = button("Pin", () => {
    pinned = pinned ? null : { ...answers };
    pin.textContent = pinned ? "Unpin" : "Pin";
    pin.setAttribute("aria-pressed", String(Boolean(pinned)));
    renderAll();
  });
  const acts = make("div", { className: "acts" },
    pin,
    button("As in the file", () => { for (const [key, one] of knobs) set(key, one.file); ask(); }),
    button("Copy link", () => {
      remember();
      navigator.clipboard?.writeText(location.href).then(() => { told.textContent = "link copied"; },
        () => { told.textContent = location.href; });
    }),
    button("Copy --set", () => {
      const words = Object.entries(settings()).map(([key, v]) => `--set ${key}=${v}`).join(" ");
      navigator.clipboard?.writeText(words).then(() => { told.textContent = words || "nothing is moved"; },
          () => { told.textContent = words; });
    }),
    button("Write to file", async () => {
      const answer = await post("write", { settings: settings() });
      prose(told, answer.problem ?? (answer.written ? `written to ${answer.written}; what it was is in ${
          answer.backup}` : "the file has these numbers already"));
      await watch();
    }));

  // Values of one curve at the horizontal positions of another.
  const onto = (xs, ys, at, log) => {
    let j = 0;
    return Array.from(at, (x) => {
      while (j + 2 < xs.length && xs[j + 1] < x) j++;
      if (x < xs[0] || x > xs[xs.length - 1] || ys[j] == null || ys[j + 1] == null) return null;
      const part = log ? Math.log(x / xs[j]) / Math.log(xs[j + 1] / xs[j]) :
          (x - xs[j]) / (xs[j + 1] - xs[j]);
      return ys[j] + Math.min(Math.max(part, 0), 1) * (ys[j + 1] - ys[j]);
    });
  };
  const withPinned = (chart, held) => {
    if (!held) return chart;
    const at = feeler.column(chart.x.values), xs = feeler.column(held.x.values);
    const old = held.series.map((series, i) => ({ ...series, name: `${series.name}, pinned`, faint: true,
        dashed: false, colour: 3 + i, values: onto(xs, feeler.column(series.values), at, chart.x.log),
        span: undefined }));
    return { ...chart, series: [...chart.series, ...old] };
  };
  const drawn = new Map();
  const drawChart = (name, chart, held) => {
    const place = $(name), figure = place.closest("figure");
    figure.hidden = !chart;
    const drop = () => { drawn.get(name)?.u?.destroy(); drawn.delete(name); };
    if (!chart) { drop(); return; }
    // A chart of rounding errors says so.
    if (chart.instead && !held) { drop(); place.textContent = chart.instead; return; }
    const whole = withPinned({ height: 230, ...chart }, held);
    const before = drawn.get(name), names = whole.series.map((series) => series.name).join("|");
    if (before && before.names === names) feeler.update(before.u, before.chart, whole);
    else {
      before?.u.destroy();
      const u = feeler.draw(place, whole);
      if (u) drawn.set(name, { u, chart: whole, names });
    }
  };
  const drawPlane = (name, plane, held) => {
    const place = $(name);
    place.closest("figure").hidden = !plane;
    if (!plane) return;
    const paths = held ? [...held.paths.map((path) => ({ ...path, name: `${path.name}, pinned`, colour: 9 })),
        ...plane.paths] : plane.paths;
    const whole = { ...plane, paths };
    const before = drawn.get(name);
    if (before) before.update(whole); else drawn.set(name, feeler.plane(place, whole));
  };
  // Hidden figures are drawn when no slider moves, or when they become visible.
  const away = new Set(), late = new Map();
  const drawLate = (name) => { const draw = late.get(name); late.delete(name); draw?.(); };
  const sight = new IntersectionObserver((seen) => {
    for (const { target, isIntersecting } of seen) {
      const name = target.id.slice("of-".length);
      if (isIntersecting) { away.delete(name); drawLate(name); } else away.add(name);
    }
  }, { rootMargin: "100px" });
  [...Object.values(PARTS).flat(), "map"].forEach((name) => sight.observe($(`of-${name}`)));
  const parts = () => Object.keys(PARTS).map((name) => answers[name] ?? {});
  // The message on the file's mistake stays until the file is corrected.
  const showProblems = (...others) => prose($("problem"), [...new Set([mistake, ...others,
      ...parts().map((one) => one.problem)])].filter(Boolean).join("\n"));
  const render = (part) => {
    const all = parts(), next = answers[part];
    showProblems();
    if (!next.charts) return;
    prose($("lead"), all.map((one) => one.lead).filter(Boolean).join(" "));
    if (part === "theory") $("stable").textContent = next.stable;
    $(`tiles-${part}`).innerHTML = next.tiles;
    for (const name of PARTS[part]) {
      // Parts without new results stay unchanged.
      if (next.partial && name === "locus" && !next.planes.locus) continue;
      late.set(name, () => {
        const [now, held] = [answers[part], pinned?.[part]];
        const isPlane = $(name).classList.contains("plane");
        if (isPlane) drawPlane(name, now.planes[name], held?.planes?.[name]);
        else drawChart(name, now.charts[name], held?.charts?.[name]);
      });
      if (!away.has(name)) drawLate(name);
    }
    if (part === "run") { late.set("map", map.here); if (!away.has("map")) drawLate("map"); }
  };
  const renderAll = () => { Object.keys(answers).forEach(render); settle(); };

  // Each part has one request at a time. The next one is computed while this result is drawn.
  const idle = () => ({ pending: null, wished: false, since: 0, latencies: [] });
  const asked = Object.fromEntries(Object.keys(PARTS).map((part) => [part, idle()]));
  const isBusy = () => Object.values(asked).some((one) => one.pending);
  const isInMotion = () => isBusy() || performance.now() - lastMove < REST_MS;
  const frame = () => new Promise((done) => requestAnimationFrame(done));
  const follow = async (part) => {
    const one = asked[part];
    if (!one.wished) one.since = performance.now();
    one.wished = true;
    if (one.pending) return;
    const send = () => {
      one.wished = false;
      // Root loci take up to a third of the time of theory, so they wait while they are not visible.
      one.pending = post("state", { settings: settings(), part, in_motion: true,
          without_loci: away.has("locus") });
      return one.since;
    };
    let began = send();
    while (one.pending) {
      const next = await one.pending, since = began;
      if (one.wished) began = send(); else one.pending = null;
      // After a mistake the drawings stay unchanged.
      answers[part] = next.charts ? next : { ...answers[part], problem: next.problem };
      render(part);
      // The results are drawn when the next frame begins.
      frame().then(() => {
        if (one.latencies.push(performance.now() - since) > LATENCIES) one.latencies.shift();
      });
    }
    await frame();
    if (!isBusy()) settle();
  };
  const ask = () => { document.body.dataset.busy = "yes"; Object.keys(PARTS).forEach(follow); };

  // Work that waits until no slider moves: the link, the rest of a long run, the map, the records, and
  // hidden figures, one per frame.
  let rests = 0;
  const settle = async () => {
    const mine = ++rests, isOver = () => mine !== rests || isBusy();
    const median = (all) => [...all].sort((a, b) => a - b)[all.length >> 1] ?? 0;
    const slower = Math.max(...Object.values(asked).map((one) => median(one.latencies)));
    document.querySelector("footer").dataset.latency = `${short(slower, 3)} ms from move to picture (median)`;
    await new Promise((done) => setTimeout(done, REST_MS));
    if (isOver()) return;
    remember();
    // The complete run, if it takes too long while a slider moves.
    for (const part of Object.keys(PARTS).filter((name) => answers[name]?.partial)) {
      const whole = await post("state", { settings: settings(), part });
      if (isOver()) return;
      answers[part] = whole.charts ? whole : { ...answers[part], problem: whole.problem, partial: false };
      render(part);
    }
    map.stale();
    replay();
    for (const name of [...late.keys()]) {
      if (isOver()) return;
      drawLate(name);
      await frame();
    }
    if (!isOver()) delete document.body.dataset.busy;
  };

  const watch = async () => {
    let file;
    try { file = await (await fetch("file")).json(); } catch {
      showProblems("The command that serves this page has ended."); return false; }
    if (file.version !== version) {
      version = file.version;
      mistake = file.problem ?? "";
      showProblems();
      if (mistake) return true;
      const moves = settings();
      build(file);
      for (const [key, v] of Object.entries(moves)) set(key, v);
      ask();
    }
    return true;
  };

  const map = feeler.mapOfTwo({ data, knobs, make, node, short, share, value, settings, post, set, moved, ask,
    isInMotion, version: () => version });

  // Records compared with the machine as set.
  const records = $("records"), charts = [];
  let chosen = 0, replaying = false, again = false;
  const dropRecords = () => charts.splice(0).forEach(({ u }) => { u.root.parentNode.remove(); u.destroy(); });
  const replay = async () => {
    if (!records) return;
    if (replaying) { again = true; return; }
    replaying = true;
    do {
      again = false;
      const answer = await post("replay", { settings: settings(), record: chosen });
      if (!answer.charts) { showProblems(answer.problem); break; }
      answer.charts.forEach((chart, i) => {
        const names = chart.series.map((series) => series.name).join("|");
        if (charts[i]?.names === names) { feeler.update(charts[i].u, charts[i].chart, chart); return; }
        const place = make("div", { className: "chart", tabIndex: 0 });
        place.setAttribute("role", "group");
        place.setAttribute("aria-label", chart.y.label);
        records.append(place);
        charts[i] = { names, chart, u: feeler.draw(place, chart) };
      });
    } while (again);
    replaying = false;
  };
  if (records) {
    const select = make("select", {}, ...data.records.map((name, i) =>
        make("option", { value: i, textContent: name })));
    select.setAttribute("aria-label", "record");
    select.onchange = () => { chosen = Number(select.value); dropRecords(); replay(); };
    records.append(make("div", { className: "chosen" }, select));
  }

  build(data.file);
  version = data.file.version;
  mistake = data.file.problem ?? "";
  new URLSearchParams(location.hash.slice(1)).forEach((v, key) => set(key, Number(v)));
  map.fill();
  ask();
  setInterval(() => { if (!document.hidden && !isBusy()) watch(); }, 700);
  let waiting;
  window.addEventListener("resize", () => {
    clearTimeout(waiting);
    waiting = setTimeout(() => { for (const { u } of [...drawn.values(), ...charts]) u?.setSize({
      width: u.root.parentNode.clientWidth, height: u.height }); }, 100);
  });
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => {
    for (const [name, one] of [...drawn]) if (one.u) { one.u.destroy(); drawn.delete(name); }
    dropRecords();
    renderAll();
  });
})();
