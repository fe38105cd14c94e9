// The map of a live page: outcomes at points of two numbers, with the present point marked.
feeler.mapOfTwo = (live) => {
  "use strict";
  const { data, knobs, make, node, short, share, value, settings, post, set, moved, ask, isInMotion } = live;
  const COLUMNS = 20, ROWS = 14, WIDTH = 640, HEIGHT = 380, LEFT = 100, BOTTOM = 58, TOP = 8, RIGHT = 12;
  const holder = document.getElementById("map");
  let keys = [], timer, run = 0, shown = "";
  const choose = (which) => {
    const select = make("select", {});
    select.setAttribute("aria-label", `${which} axis of the map`);
    select.onchange = () => { keys = [x.value, y.value]; stale(true); };
    return select;
  };
  const x = choose("horizontal"), y = choose("vertical");
  const svg = node("svg", { viewBox: `0 0 ${WIDTH} ${HEIGHT}`, role: "img",
      "aria-label": "map of outcomes" });
  const legend = make("ul", { className: "swatches" }), read = make("p", { className: "told" });
  holder.append(make("div", { className: "chosen" }, "across ", x, " up ", y), svg, legend, read);
  const fill = () => {
    const names = [...knobs.keys()];
    for (const select of [x, y]) select.replaceChildren(...names.map((name) => make("option",
        { value: name, textContent: name })));
    const gain = names.includes(data.gain) ? data.gain : names[0];
    const other = names.find((name) => /^contacts\..*\.stiffness$/.test(name)) ?? names.find((name) =>
        name !== gain);
    if (!keys.every((key) => names.includes(key)) || !keys.length) keys = [gain, other ?? gain];
    [x.value, y.value] = keys;
  };
  const width = WIDTH - LEFT - RIGHT, height = HEIGHT - TOP - BOTTOM;
  const place = (i, j) => [LEFT + width * i / COLUMNS, TOP + height * (ROWS - 1 - j) / ROWS];
  const at = (range, i, count) => Number(short(value(range, (i + 0.5) / count), 5));
  const here = () => {
    svg.querySelectorAll(".here").forEach((mark) => mark.remove());
    const [a, b] = keys.map((key) => knobs.get(key));
    if (!a || !b) return;
    const cx = LEFT + width * share(a.range, a.value), cy = TOP + height * (1 - share(b.range, b.value));
    for (const kind of ["here edge", "here"]) svg.append(node("circle", { cx, cy, r: 7, class: kind }));
  };
  const axes = (a, b) => {
    for (const [one, count, across] of [[a, COLUMNS, true], [b, ROWS, false]]) {
      for (let k = 0; k <= 4; k++) {
        const [v] = feeler.tickTexts([Number(short(value(one.range, k / 4), 3))]);
        if (across) svg.append(node("text", { x: LEFT + width * k / 4, y: HEIGHT - 34,
            "text-anchor": k === 4 ? "end" : "middle" }, v));
        else svg.append(node("text", { x: LEFT - 6, y: TOP + height * (1 - k / 4) + (k === 4 ? 16 : 5),
            "text-anchor": "end" }, v));
      }
    }
    const named = (one) => one.unit ? `${one.key} (${one.unit})` : one.key;
    svg.append(node("text", { x: LEFT + width / 2, y: HEIGHT - 8, "text-anchor": "middle" }, named(a)));
    svg.append(node("text", { x: 18, y: TOP + height / 2, "text-anchor": "middle",
        transform: `rotate(-90 18 ${TOP + height / 2})` }, named(b)));
  };
  const compute = async () => {
    const mine = ++run, began = performance.now();
    const [a, b] = keys.map((key) => knobs.get(key));
    if (!a || !b || a === b) return;
    svg.replaceChildren();
    for (const key of ["coarse", "filled", "done"]) delete holder.dataset[key];
    axes(a, b);
    here();
    // First a coarse map: a quarter of the points, with outcomes estimated from the starts of their runs.
    const cellsOf = (odd, step) => {
      const found = [];
      for (let j = step; j < ROWS; j += 2) for (let i = odd; i < COLUMNS; i += 2) found.push([i, j]);
      return found;
    };
    const guesses = cellsOf(0, 0);
    const all = [...guesses, ...guesses, ...cellsOf(1, 1), ...cellsOf(0, 1), ...cellsOf(1, 0)];
    const drawn = new Map();
    for (let from = 0; from < all.length;) {
      // Slider moves have priority.
      while (isInMotion()) await new Promise((done) => setTimeout(done, 50));
      const guess = from < guesses.length;
      const part = all.slice(from, Math.min(from + data.chunk, guess ? guesses.length : all.length));
      const points = part.map(([i, j]) => [at(a.range, i, COLUMNS), at(b.range, j, ROWS)]);
      const answer = await post("map", { settings: settings(), keys: { x: a.key, y: b.key }, points,
          guess });
      if (mine !== run || !answer.outcomes) return;
      const group = document.createDocumentFragment();
      part.forEach(([i, j], k) => {
        // A coarse point covers its neighbours until their outcomes are known.
        const size = i % 2 || j % 2 ? 1 : 2;
        const name = answer.outcomes[k], [px, py] = place(i, j + size - 1);
        const cell = node("rect", { x: px, y: py, width: size * width / COLUMNS + 0.5,
            height: size * height / ROWS + 0.5, class: "place",
            fill: data.outcomes[name]?.colour ?? "#000000" });
        const where = `${a.key} = ${points[k][0]}, ${b.key} = ${points[k][1]}`;
        const label = `${where}: ${data.outcomes[name]?.label ?? "cannot run"}`;
        cell.append(node("title", {}, label));
        cell.onpointerenter = () => { read.textContent = label; };
        cell.onclick = () => { set(a.key, points[k][0]); set(b.key, points[k][1]); ask(); };
        drawn.get(`${i} ${j}`)?.cell.remove();
        drawn.set(`${i} ${j}`, { cell, name });
        group.append(cell);
      });
      from += part.length;
      holder.dataset.done = from;
      svg.append(group);
      here();
      if (from >= guesses.length) holder.dataset.coarse ??= short(performance.now() - began, 3);
      legend.replaceChildren(...[...new Set([...drawn.values()].map((one) => one.name))].map((name) => {
        const swatch = make("i", {});
        swatch.style.background = data.outcomes[name]?.colour ?? "#000000";
        return make("li", {}, swatch, data.outcomes[name]?.label ?? "cannot run");
      }));
    }
    holder.dataset.filled = short(performance.now() - began, 3);
  };
  // Only a change of a number that is not on the axes needs a new map, which waits while a slider moves.
  const stale = (now) => {
    const rest = Object.entries(settings()).filter(([key]) => !keys.includes(key));
    const ranges = keys.map((key) => knobs.get(key)?.range);
    const wanted = JSON.stringify([keys, rest, ranges, live.version()]);
    if (wanted === shown) return;
    shown = wanted;
    clearTimeout(timer);
    timer = setTimeout(compute, now ? 0 : 300);
  };
  holder.onkeydown = (event) => {
    const way = { ArrowLeft: [0, -1], ArrowRight: [0, 1], ArrowUp: [1, 1], ArrowDown: [1, -1] }[event.key];
    if (!way || event.target !== holder) return;
    const one = knobs.get(keys[way[0]]);
    moved(one.key, Number(short(value(one.range, Math.min(1,
        Math.max(0, share(one.range, one.value) + way[1] / COLUMNS))), 4)));
    event.preventDefault();
  };
  return { fill, here, stale };
};
