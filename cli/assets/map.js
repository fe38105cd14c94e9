// Says under each map which variant the pointer is over, and how to run it; a click copies the command.
(() => {
  "use strict";
  const maps = JSON.parse(document.getElementById("data").textContent).maps;
  const short = (value) => typeof value === "number" ? Number(value.toPrecision(5)).toString() : value;
  document.querySelectorAll(".map").forEach((holder) => {
    const map = maps[Number(holder.dataset.map)], svg = holder.querySelector("svg"), told = holder.nextElementSibling;
    if (!map || !svg) return;
    const locate = (event) => {
      const point = new DOMPoint(event.clientX, event.clientY).matrixTransform(svg.getScreenCTM().inverse());
      // Later ones lie on top.
      for (let i = map.places.length - 1; i >= 0; i--) {
        const [x, y, width, height, row] = map.places[i];
        if (point.x >= x && point.x < x + width && point.y >= y && point.y < y + height) return row;
      }
      return null;
    };
    const command = (row) => map.command + map.settings.map(([key, values]) => ` --set '${key}=${values[row]}'`).join("");
    let shown = null;
    holder.addEventListener("pointermove", (event) => {
      const row = locate(event);
      if (row === shown) return;
      shown = row;
      if (row === null) { told.textContent = "\u00a0"; return; }
      const figures = map.columns.filter(([, values]) => values[row] !== null).map(([name, values, unit]) => `${name} ${short(values[row])}${unit ? " " + unit : ""}`);
      told.textContent = `${figures.join(", ")}\n${command(row)}`;
      told.style.whiteSpace = "pre-wrap";
    });
    holder.addEventListener("click", (event) => {
      const row = locate(event);
      if (row !== null && navigator.clipboard) navigator.clipboard.writeText(command(row)).then(() => { told.textContent += "   (copied)"; });
    });
  });
})();
