// Shows below each map the variant under the pointer, and the command that runs it. A click copies the
// command.
(() => {
  "use strict";
  const maps = JSON.parse(document.getElementById("data").textContent).maps;
  const short = (value) => typeof value === "number" ? Number(value.toPrecision(5)).toString() : value;
  // Formats numbers as on the axes: at most four digits before the point, with a prefix if the unit accepts
  // one.
  const PREFIXES = [[1e9, "G"], [1e6, "M"], [1e3, "k"], [1, ""], [1e-3, "m"], [1e-6, "\u00b5"], [1e-9, "n"]];
  const withUnit = (value, unit) => {
    const size = Math.abs(value);
    const isPlain = size === 0 || (size >= 1 && size < 1e4) || !/^(N|J|V|A|Hz|m|s|rad)/.test(unit);
    if (typeof value !== "number" || isPlain) return `${short(value)} ${unit}`.trim();
    const [scale, prefix] = PREFIXES.find(([scale]) => size >= scale) ?? PREFIXES.at(-1);
    return `${short(value / scale)} ${prefix}${unit}`;
  };
  document.querySelectorAll(".map").forEach((holder) => {
    const map = maps[Number(holder.dataset.map)], svg = holder.querySelector("svg"),
        told = holder.nextElementSibling;
    if (!map || !svg) return;
    const centre = (row) => { const [x, y, width, height] = map.places[row];
      return [x + width / 2, y + height / 2]; };
    let shown = null;
    const zoom = feeler.zoom(svg, map.fine, () => typeof shown === "number" ?
        zoom.shares(centre(shown)) : null);
    const locate = (event) => {
      const found = new DOMPoint(event.clientX, event.clientY).matrixTransform(svg.getScreenCTM().inverse());
      const seen = [found.x, found.y];
      const variant = zoom?.variant(seen);
      if (variant) return variant;
      if (zoom && !zoom.holds(seen)) return null;
      const [px, py] = zoom ? zoom.back(seen) : seen;
      // Later places are drawn over earlier ones.
      for (let i = map.places.length - 1; i >= 0; i--) {
        const [x, y, width, height] = map.places[i];
        if (px >= x && px < x + width && py >= y && py < y + height) return i;
      }
      return null;
    };
    // A column with few distinct values lists these once, with an index for each place.
    const of = ([, values], row) => Array.isArray(values) ? values[row] : values.of[values.at[row]];
    // Enough digits to resolve 1e-4 of the distance to a neighbour. Digits beyond twelve are rounding
    // errors.
    const FINEST = 1e-4, MOST_DIGITS = 12;
    const written = (value, room) => {
      if (typeof value !== "number") return String(value);
      for (let digits = 1; digits < MOST_DIGITS; digits++) {
        const short = Number(value.toPrecision(digits));
        if (Math.abs(short - value) <= room) return String(short);
      }
      return String(Number(value.toPrecision(MOST_DIGITS)));
    };
    const settings = map.columns.slice(0, map.settings);
    const rooms = settings.map(([, values]) => {
      const all = [...new Set(Array.isArray(values) ? values : values.of)].filter(Number.isFinite);
      all.sort((a, b) => a - b);
      const steps = all.slice(1).map((value, i) => value - all[i]);
      return steps.length ? FINEST * steps.reduce((least, step) => Math.min(least, step)) : 0;
    });
    const set = (i, value) => ` --set '${settings[i][0]}=${written(value, rooms[i]).replaceAll("'",
        "'\\''")}'`;
    // A variant that a thinned map does not draw has its own values on the axes.
    const valueOf = (column, row) => {
      const axis = typeof row === "number" ? -1 : map.fine.keys.indexOf(column[0]);
      return axis >= 0 ? row.values[axis] : of(column, typeof row === "number" ? row : 0);
    };
    const command = (row) => map.commands ? map.commands[row] :
        map.command + settings.map((column, i) => set(i, valueOf(column, row))).join("");
    const tell = (row) => {
      if (row === shown) return;
      shown = row;
      if (row === null) { told.textContent = "\u00a0"; return; }
      const known = typeof row === "number" ? map.columns.filter((column) => of(column, row) !== null) :
          settings;
      const figures = known.map((column) => `${column[0]} ${withUnit(valueOf(column, row), column[2])}`);
      if (typeof row !== "number") figures.push(row.label);
      told.textContent = `${figures.join(", ")}\n${command(row)}`;
      told.style.whiteSpace = "pre-wrap";
    };
    const copy = () => {
      const row = shown;
      if (row === null || !navigator.clipboard) return;
      navigator.clipboard.writeText(command(row)).then(() => {
        if (shown === row && !told.textContent.endsWith("(copied)")) told.textContent += "   (copied)"; },
          () => {});
    };
    holder.addEventListener("pointermove", (event) => tell(locate(event)));
    // On a touch screen there is no pointer movement before the click.
    holder.addEventListener("click", (event) => { tell(locate(event)); copy(); });
    holder.addEventListener("keydown", (event) => {
      const by = { ArrowRight: 1, ArrowDown: 1, ArrowLeft: -1, ArrowUp: -1 }[event.key],
          count = map.places.length;
      const last = typeof shown === "number" ? shown : by > 0 ? -1 : 0;
      if (by) tell((last + by + count) % count);
      else if (event.key === "Enter") copy();
      else if (!zoom?.key(event)) return;
      event.preventDefault();
    });
  });
})();
