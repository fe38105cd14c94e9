// Draws an animated scene in space: an arm, its tool and a workpiece, in parallel projection from any side.
// Dragging turns the view, and the wheel zooms.
(() => {
  "use strict";
  const page = JSON.parse(document.getElementById("data").textContent);
  const WIDTH = 1040, HEIGHT = 520, ROOM = 1.0;
  const ARROW = 120, ARROW_CLOSE = 160;
  const dark = () => matchMedia("(prefers-color-scheme: dark)").matches &&
      !document.documentElement.classList.contains("print");
  const colour = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();
  const turned = ([x, y, z, w], v) => {
    const t = [2 * (y * v[2] - z * v[1]), 2 * (z * v[0] - x * v[2]), 2 * (x * v[1] - y * v[0])];
    return [
      v[0] + w * t[0] + y * t[2] - z * t[1],
      v[1] + w * t[1] + z * t[0] - x * t[2],
      v[2] + w * t[2] + x * t[1] - y * t[0],
    ];
  };
  const points = (frame) => {
    const flat = frame[1], all = [[0, 0, 0]];
    for (let i = 0; i < flat.length; i += 3) all.push([flat[i], flat[i + 1], flat[i + 2]]);
    return all;
  };

  const show = (place) => {
    const scene = page.scenes[place.dataset.scene];
    const canvas = document.createElement("canvas");
    canvas.className = "scene-picture";
    canvas.setAttribute("role", "img");
    canvas.setAttribute("aria-label", "the arm in space; Play moves it");
    const density = Math.max(2, window.devicePixelRatio || 1);
    canvas.width = WIDTH * density;
    canvas.height = HEIGHT * density;
    const ctx = canvas.getContext("2d");
    const make = (name, set) => Object.assign(document.createElement(name), set);
    const controls = make("div", { className: "scene-controls" });
    const play = make("button", { type: "button", textContent: "Play" });
    const slider = make("input", { type: "range", min: 0, max: scene.frames.length - 1, step: 1, value: 0 });
    slider.setAttribute("aria-label", "time");
    const speed = make("select", {});
    speed.setAttribute("aria-label", "speed");
    for (const [name, value] of [["real time", 1], ["slowed 5 times", 0.2], ["slowed 20 times", 0.05],
        ["slowed 100 times", 0.01]]) {
      speed.append(make("option", { textContent: name, value }));
    }
    speed.value = 0.2;
    const closer = make("button", { type: "button", textContent: "Show the tip" });
    const told = make("output", {});
    controls.append(play, slider, speed, closer, told);
    place.append(canvas, controls);

    // The contents of the views: the whole arm and its workpiece, or the surroundings of the tip.
    const corners = (from) => {
      const low = [Infinity, Infinity, Infinity], high = [-Infinity, -Infinity, -Infinity];
      for (const p of from) for (let k = 0; k < 3; k++) { low[k] = Math.min(low[k], p[k]);
        high[k] = Math.max(high[k], p[k]); }
      return [low, high];
    };
    const ends = scene.workpiece.flatMap((l) => [l.slice(0, 3), l.slice(3, 6)]);
    const sampled = scene.frames.filter((_, i) =>
        i % Math.ceil(scene.frames.length / 40) === 0).flatMap(points);
    // A workpiece much larger than the arm is regarded as a ground, and does not affect the view.
    const [armLow, armHigh] = corners(sampled);
    const size = Math.hypot(...armHigh.map((h, k) => h - armLow[k]));
    const near = ends.filter((p) => Math.hypot(...p.map((x, k) => x - 0.5 * (armLow[k] +
        armHigh[k]))) < size);
    const [low, high] = corners(sampled.concat(near));
    const whole = { centre: low.map((l, k) => 0.5 * (l + high[k])), scale: ROOM * HEIGHT / Math.max(0.05,
        Math.hypot(...high.map((h, k) => h - low[k])) ) };
    const last = points(scene.frames[scene.frames.length - 1]).pop();
    const tipSize = scene.ball ? scene.ball[1] : 0.02;
    const tip = { centre: last, scale: HEIGHT / (10 * tipSize) };
    let view = { ...whole, yaw: -0.9, pitch: 0.35 }, isClose = false, now = 0, playing = false, begun = 0,
        from = 0;

    const project = (p) => {
      const d = p.map((x, k) => x - view.centre[k]);
      const [cy, sy, cp, sp] = [Math.cos(view.yaw), Math.sin(view.yaw), Math.cos(view.pitch),
          Math.sin(view.pitch)];
      const right = -sy * d[0] + cy * d[1], ahead = cy * d[0] + sy * d[1];
      return [WIDTH / 2 + view.scale * right, HEIGHT / 2 - view.scale * (cp * d[2] - sp * ahead),
          -(cp * ahead + sp * d[2])];
    };
    // On a narrow screen the picture is smaller and its letters are larger.
    const lettering = () =>
        `${Math.max(13, 12 * WIDTH / (canvas.clientWidth || WIDTH))}px system-ui, sans-serif`;
    const segment = (a, b) => { ctx.moveTo(a[0], a[1]); ctx.lineTo(b[0], b[1]); };
    const capsule = (a, b, width, fill, edge) => {
      for (const [w, style] of [[width + 2, edge], [width, fill]]) {
        ctx.strokeStyle = style; ctx.lineWidth = Math.max(w, 1.5); ctx.lineCap = "round";
        ctx.beginPath(); segment(a, b); ctx.stroke();
      }
    };
    const outline = (lines, place, style, width) => {
      ctx.strokeStyle = style; ctx.lineWidth = width; ctx.lineCap = "butt";
      ctx.beginPath();
      for (const l of lines) segment(project(place(l.slice(0, 3))), project(place(l.slice(3, 6))));
      ctx.stroke();
    };
    const bar = () => {
      // A round length for the scale bar, at most a fifth of the picture.
      const most = 0.2 * WIDTH / view.scale, power = 10 ** Math.floor(Math.log10(most));
      const length = [5, 2, 1].map((m) => m * power).find((l) => l <= most), pixels = length * view.scale;
      ctx.strokeStyle = ctx.fillStyle = colour("--text"); ctx.lineWidth = 1.5; ctx.font = lettering();
        ctx.textAlign = "left";
      ctx.beginPath(); ctx.moveTo(20, HEIGHT - 26); ctx.lineTo(20, HEIGHT - 20); ctx.lineTo(20 + pixels,
          HEIGHT - 20); ctx.lineTo(20 + pixels, HEIGHT - 26); ctx.stroke();
      const text = length >= 1 ? `${length} m` : length >= 1e-3 ? `${Math.round(length * 1e3)} mm` :
          `${Math.round(length * 1e6)} \u00b5m`;
      ctx.fillText(text, 26, HEIGHT - 28);
    };
    const compass = () => {
      const origin = [WIDTH - 60, HEIGHT - 56];
      ctx.font = lettering(); ctx.textAlign = "center"; ctx.lineWidth = 1.5;
      [["x", [1, 0, 0]], ["y", [0, 1, 0]], ["z", [0, 0, 1]]].forEach(([name, axis]) => {
        const end = project(axis.map((a, k) => view.centre[k] + a * 34 / view.scale));
        const way = [end[0] - WIDTH / 2, end[1] - HEIGHT / 2];
        ctx.strokeStyle = ctx.fillStyle = colour("--soft");
        ctx.beginPath(); ctx.moveTo(...origin); ctx.lineTo(origin[0] + way[0], origin[1] + way[1]);
          ctx.stroke();
        ctx.fillText(name, origin[0] + 1.3 * way[0], origin[1] + 1.3 * way[1] + 4);
      });
    };
    const arrow = (at, normal, force) => {
      const length = (isClose ? ARROW_CLOSE : ARROW) * force / Math.max(scene.largest, 1e-9);
      if (length < 1) return;
      const a = project(at), b = project(at.map((x, k) => x - normal[k] / view.scale));
      const way = [b[0] - a[0], b[1] - a[1]], long = Math.hypot(...way);
      // Seen along its axis, the arrow has no length to draw.
      if (long < 0.05) return;
      const end = [a[0] + way[0] * length, a[1] + way[1] * length], unit = way.map((w) => w / long),
          head = Math.min(12, 0.5 * length);
      ctx.strokeStyle = ctx.fillStyle = dark() ? "#e69f00" : "#d55e00"; ctx.lineWidth = 3;
        ctx.lineCap = "butt";
      ctx.beginPath(); segment(a, [end[0] - unit[0] * head, end[1] - unit[1] * head]); ctx.stroke();
      ctx.beginPath(); ctx.moveTo(...end);
      ctx.lineTo(end[0] - unit[0] * head - unit[1] * head * 0.5, end[1] - unit[1] * head +
          unit[0] * head * 0.5);
      ctx.lineTo(end[0] - unit[0] * head + unit[1] * head * 0.5,
          end[1] - unit[1] * head - unit[0] * head * 0.5);
      ctx.fill();
    };

    const paint = () => {
      const [t, , turn, force, contact] = scene.frames[now];
      const skeleton = points(scene.frames[now]), tool = skeleton[skeleton.length - 1];
      ctx.setTransform(density, 0, 0, density, 0, 0);
      ctx.fillStyle = colour("--ground"); ctx.fillRect(0, 0, WIDTH, HEIGHT);
      // From a distance the lines of a fine mesh would merge.
      ctx.globalAlpha = isClose ? 0.7 : Math.max(0.25, Math.min(1, 400 / scene.workpiece.length));
      outline(scene.workpiece, (p) => p, dark() ? "#56b4e9" : "#0072b2", isClose ? 1 : 0.6);
      ctx.globalAlpha = 1;
      const shades = dark() ? ["#4a555c", "#56626a"] : ["#c9d1d6", "#dbe1e5"];
      const placed = (p) => turned(turn, p).map((x, k) => x + tool[k]);
      // The drawn tool ends at the centre of a round tip.
      const drawn = scene.ball ? [...skeleton.slice(0, -1), placed(scene.ball[0])] : skeleton;
      const links = [];
      for (let i = 0; i + 1 < drawn.length; i++) {
        const a = project(drawn[i]), b = project(drawn[i + 1]);
        links.push([0.5 * (a[2] + b[2]), a, b, 2 * scene.radii[i] * view.scale, shades[i % 2]]);
      }
      // Near the tip the links would hide the tip.
      ctx.globalAlpha = isClose ? 0.35 : 1;
      for (const [, a, b, width, shade] of links.sort((p, q) => p[0] - q[0])) capsule(a, b, width, shade,
          colour("--soft"));
      ctx.globalAlpha = 1;
      ctx.fillStyle = colour("--text");
      if (!isClose) for (const p of skeleton.slice(1, -1)) { const a = project(p); ctx.beginPath();
        ctx.arc(a[0], a[1], 2.5, 0, 7); ctx.fill(); }
      if (scene.ball) {
        const a = project(placed(scene.ball[0]));
        ctx.strokeStyle = colour("--text"); ctx.lineWidth = 1.5;
        ctx.beginPath(); ctx.arc(a[0], a[1], Math.max(1.5, scene.ball[1] * view.scale), 0, 7); ctx.stroke();
      } else outline(scene.tip, placed, colour("--text"), 1.2);
      if (force > 0 && contact[0] != null) arrow(contact.slice(0, 3), contact.slice(3, 6), force);
      bar();
      compass();
      told.textContent = `${t.toFixed(3)} s \u00b7 ${force.toFixed(2)} N`;
      slider.value = now;
    };

    // Charts follow the controls, and the picture follows the pointer on a chart.
    const move = () => {
      paint();
      document.dispatchEvent(new CustomEvent("feeler:scene", { detail: scene.frames[now][0] }));
    };
    const stop = () => { playing = false; play.textContent = "Play"; };
    const tick = (clock) => {
      if (!playing) return;
      const t = from + (clock - begun) / 1000 * Number(speed.value);
      while (now + 1 < scene.frames.length && scene.frames[now + 1][0] <= t) now++;
      move();
      if (now + 1 >= scene.frames.length) stop(); else requestAnimationFrame(tick);
    };
    const start = () => {
      if (now + 1 >= scene.frames.length) now = 0;
      playing = true; play.textContent = "Pause"; from = scene.frames[now][0];
      requestAnimationFrame((clock) => { begun = clock; tick(clock); });
    };
    play.onclick = () => { if (playing) stop(); else start(); };
    speed.onchange = () => { if (playing) start(); };
    slider.oninput = () => { stop(); now = Number(slider.value); move(); };
    document.addEventListener("feeler:chart", ({ detail: t }) => {
      const next = Math.max(scene.frames.findLastIndex((frame) => frame[0] <= t), 0);
      if (next === now) return;
      stop();
      now = next;
      paint();
    });
    closer.onclick = () => {
      isClose = !isClose;
      closer.textContent = isClose ? "Show the whole" : "Show the tip";
      view = { ...view, ...(isClose ? tip : whole), ...(isClose ? { pitch: 0.12 } : { pitch: 0.35 }) };
      paint();
    };
    canvas.onpointerdown = (event) => { canvas.setPointerCapture(event.pointerId); };
    canvas.onpointermove = (event) => {
      if (!event.buttons) return;
      view.yaw -= event.movementX * 0.008;
      view.pitch = Math.max(-1.57, Math.min(1.57, view.pitch + event.movementY * 0.008));
      paint();
    };
    canvas.addEventListener("wheel", (event) => { event.preventDefault();
      view.scale *= Math.exp(-event.deltaY * 0.0012); paint(); }, { passive: false });
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", paint);
    window.addEventListener("beforeprint", () => { document.documentElement.classList.add("print"); paint();
      });
    // A static picture shows the instant of the largest force.
    now = scene.frames.reduce((best, frame, i) => (frame[3] > scene.frames[best][3] ? i : best), 0);
    paint();
  };
  document.querySelectorAll(".scene").forEach(show);
})();
