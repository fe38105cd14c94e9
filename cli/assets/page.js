// Draws the charts of a page from its data, and again when width, colours or print change.
(() => {
  "use strict";
  const page = JSON.parse(document.getElementById("data").textContent);
  const PRINT = { width: 680, height: 210 };
  let drawn = [];
  const draw = ({ width, ...paper } = {}) => {
    drawn.forEach((u) => u.destroy());
    drawn = [...document.querySelectorAll(".chart[data-chart]")].map((place) => feeler.draw(place,
        { ...page.charts[place.dataset.chart], ...paper }, { width })).filter(Boolean);
  };
  draw();
  // Time charts mark the instant that a scene shows.
  document.addEventListener("feeler:scene", ({ detail: t }) => {
    for (const u of drawn) {
      const { min, max } = u.scales.x;
      if (u.together && t >= min && t <= max) u.setCursor({ left: u.valToPos(t, "x"),
          top: u.over.clientHeight / 2 }, false, false);
    }
  });
  let waiting;
  const widths = () => drawn.forEach((u) => u.setSize({ width: u.root.parentNode.clientWidth,
      height: u.height }));
  window.addEventListener("resize", () => { clearTimeout(waiting); waiting = setTimeout(widths, 100); });
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => draw());
  window.addEventListener("beforeprint", () => { document.documentElement.classList.add("print");
    draw(PRINT); });
  window.addEventListener("afterprint", () => { document.documentElement.classList.remove("print"); draw();
    });
})();
