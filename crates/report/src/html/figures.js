// Figures that can be read off: the pointer or the arrow keys show values, dragging or + and - zoom, Escape goes back.
// Everything is made from the drawing itself; without this script it is as it was.
"use strict";
for (const svg of document.querySelectorAll("figure svg[data-panels]")) {
  const NS = "http://www.w3.org/2000/svg";
  const make = (name, parent, attributes) => {
    const element = document.createElementNS(NS, name);
    for (const key in attributes) element.setAttribute(key, attributes[key]);
    return parent.appendChild(element);
  };
  const across = svg.querySelector("[data-x]")?.dataset.x;
  const upwards = [...svg.querySelectorAll("[data-y]")].map(label => label.dataset.y);
  // left, top, right, bottom, then of x and y: logarithmic or not, ends of the axis; at last of both the power of ten and the number
  // that the label has and the ticks have not
  const panels = JSON.parse(svg.dataset.panels).map((p, i) => ({
    name: upwards[i],
    left: p[0], top: p[1], right: p[2], bottom: p[3],
    x: { log: p[4], low: p[5], high: p[6], unit: 10 ** (p[10] || 0), base: p[11] || 0 },
    y: { log: p[7], low: p[8], high: p[9], unit: 10 ** (p[12] || 0), base: p[13] || 0 },
    data: svg.querySelectorAll("g[data-panel]")[i], ticks: svg.querySelectorAll(`g[data-ticks="${i}"]`), view: null,
  }));
  const series = [];
  const pairs = numbers => (numbers.match(/-?[\d.]+ -?[\d.]+/g) || []).map(pair => pair.split(" ").map(Number));
  for (const panel of panels) {
    // A line has its points in its path; markers are one series by their name.
    const marked = {};
    for (const mark of panel.data.querySelectorAll("[data-series]")) {
      const name = mark.dataset.series;
      if (mark.dataset.mark === undefined) series.push({ panel, name, points: pairs(mark.getAttribute("d")) });
      else (marked[name] ||= { panel, name, points: [] }).points.push(...pairs(mark.dataset.mark));
    }
    series.push(...Object.values(marked));
  }
  if (!series.length) continue;
  const lines = svg.appendChild(document.createElementNS(NS, "g"));
  const output = document.createElement("output");
  output.className = "read-off";
  svg.parentNode.after(output);
  const help = matchMedia("(hover: none)").matches ? "A touch shows values; push the figure sideways." : "Pointer or ← → show values, ↑ ↓ change the curve; drag or + − zoom; Esc goes back.";
  output.textContent = help;
  svg.setAttribute("tabindex", "0");
  const value = (axis, share) => {
    const [a, b] = axis.log ? [Math.log10(axis.low), Math.log10(axis.high)] : [axis.low, axis.high];
    const v = a + share * (b - a);
    return axis.log ? 10 ** v : v;
  };
  // As the label of the axis says it: less its number, over its power of ten.
  const text = (axis, number) => {
    const v = (number - axis.base) / axis.unit;
    const digits = axis.log ? 4 : Math.min(9, Math.max(4, Math.ceil(Math.log10(Math.abs(v) * axis.unit / Math.abs(axis.high - axis.low) || 1)) + 4));
    return Number(v.toPrecision(digits)).toString().replaceAll("-", "−").replace(/e\+?(−?\d+)$/, "·10^$1");
  };
  // A label is the quantity over its unit, which equals the number.
  const named = (label, number) => label ? `${label} = ${number}` : number;
  // From the pixels of the drawing to those of the view, and back.
  const whole = p => ({ left: p.left, right: p.right, top: p.top, bottom: p.bottom });
  const forth = (p, [x, y]) => {
    const v = p.view || whole(p);
    return [p.left + (x - v.left) / (v.right - v.left) * (p.right - p.left),
      p.top + (y - v.top) / (v.bottom - v.top) * (p.bottom - p.top)];
  };
  const back = (p, [x, y]) => {
    const v = p.view || whole(p);
    return [v.left + (x - p.left) / (p.right - p.left) * (v.right - v.left),
      v.top + (y - p.top) / (p.bottom - p.top) * (v.bottom - v.top)];
  };
  const read = (p, [x, y]) => [value(p.x, (x - p.left) / (p.right - p.left)), value(p.y, (p.bottom - y) / (p.bottom - p.top))];
  let at = null;
  const show = () => {
    lines.textContent = "";
    if (!at) { output.textContent = help; return; }
    const { panel, points, name } = series[at.series], point = points[at.point];
    const [x, y] = forth(panel, point), [u, v] = read(panel, point);
    const ink = { stroke: "#000", "stroke-width": .7, "stroke-dasharray": "2 2" };
    if (x >= panel.left - 1 && x <= panel.right + 1) for (const p of panels) make("line", lines, { x1: x, x2: x, y1: p.top, y2: p.bottom, ...ink });
    if (y >= panel.top && y <= panel.bottom) make("circle", lines, { cx: x, cy: y, r: 4, fill: "none", stroke: "#000" });
    output.textContent = (name ? name + ": " : "") + named(across, text(panel.x, u)) + ", " + named(panel.name, text(panel.y, v));
  };
  const place = event => {
    const box = svg.getBoundingClientRect(), view = svg.viewBox.baseVal;
    return [(event.clientX - box.left) / box.width * view.width, (event.clientY - box.top) / box.height * view.height];
  };
  const inside = ([x, y]) => panels.find(p => x >= p.left && x <= p.right && y >= p.top && y <= p.bottom);
  const nearest = (panel, [x, y]) => {
    let best = null;
    series.forEach((s, i) => {
      if (s.panel !== panel) return;
      s.points.forEach((point, j) => {
        const [a, b] = forth(panel, point), far = (a - x) ** 2 + .1 * (b - y) ** 2;
        if (!best || far < best.far) best = { series: i, point: j, far };
      });
    });
    return best;
  };
  const ticks = (axis, from, to) => {
    const [low, high] = [value(axis, from), value(axis, to)], list = [];
    if (axis.log && high / low > 20) {
      for (let e = Math.ceil(Math.log10(low)); e <= Math.log10(high); e++) list.push(10 ** e);
      return list;
    }
    const raw = (high - low) / 6, power = 10 ** Math.floor(Math.log10(raw));
    const step = [1, 2, 5, 10].find(k => k * power >= raw) * power;
    for (let k = Math.ceil(low / step); k * step <= high; k++) list.push(k * step);
    return list;
  };
  const draw = p => {
    p.own?.remove();
    const v = p.view || whole(p), sx = (p.right - p.left) / (v.right - v.left), sy = (p.bottom - p.top) / (v.bottom - v.top);
    for (const mark of p.data.children) {
      if (mark.dataset.mark !== undefined) {
        const [x, y] = mark.dataset.mark.split(" ").map(Number), [a, b] = forth(p, [x, y]);
        mark.setAttribute("transform", `translate(${a - x} ${b - y})`);
      } else {
        mark.setAttribute("transform", `matrix(${sx} 0 0 ${sy} ${p.left - sx * v.left} ${p.top - sy * v.top})`);
        mark.setAttribute("vector-effect", "non-scaling-stroke");
      }
    }
    for (const group of p.ticks) group.style.display = p.view ? "none" : "";
    if (!p.view) return;
    p.own = make("g", svg, { "font-size": 11, fill: "#333" });
    const share = (axis, t) => axis.log ? Math.log(t / axis.low) / Math.log(axis.high / axis.low) : (t - axis.low) / (axis.high - axis.low);
    const ends = [(v.left - p.left) / (p.right - p.left), (v.right - p.left) / (p.right - p.left)];
    for (const t of ticks(p.x, ...ends)) {
      const [x] = forth(p, [p.left + share(p.x, t) * (p.right - p.left), 0]);
      make("line", p.own, { x1: x, x2: x, y1: p.bottom, y2: p.bottom - 6, stroke: "#333" });
      if (p === panels[panels.length - 1]) make("text", p.own, { x, y: p.bottom + 15, "text-anchor": "middle" }).textContent = text(p.x, t);
    }
    for (const t of ticks(p.y, (p.bottom - v.bottom) / (p.bottom - p.top), (p.bottom - v.top) / (p.bottom - p.top))) {
      const [, y] = forth(p, [0, p.bottom - share(p.y, t) * (p.bottom - p.top)]);
      make("line", p.own, { x1: p.left, x2: p.left + 6, y1: y, y2: y, stroke: "#333" });
      make("text", p.own, { x: p.left - 6, y: y + 4, "text-anchor": "end" }).textContent = text(p.y, t);
    }
  };
  // Panels share their horizontal axis; only the one that was zoomed changes its vertical one.
  const zoom = (panel, from, to) => {
    for (const p of panels) {
      const v = p.view || whole(p);
      if (!panel) p.view = null;
      else p.view = { left: from[0], right: to[0], top: p === panel ? from[1] : v.top, bottom: p === panel ? to[1] : v.bottom };
      draw(p);
    }
    show();
  };
  let drag = null;
  svg.addEventListener("pointermove", event => {
    const here = place(event);
    if (drag) {
      drag.box?.remove();
      const [x, y] = drag.from;
      drag.box = make("rect", svg, { x: Math.min(x, here[0]), y: Math.min(y, here[1]), width: Math.abs(x - here[0]), height: Math.abs(y - here[1]), fill: "#0072b2", "fill-opacity": .15 });
      return;
    }
    const panel = inside(here);
    at = panel ? nearest(panel, here) : null;
    show();
  });
  svg.addEventListener("pointerdown", event => {
    const from = place(event), panel = inside(from);
    if (event.pointerType !== "mouse") { at = panel ? nearest(panel, from) : null; show(); return; }
    if (panel && event.pointerType === "mouse" && event.button === 0) { drag = { panel, from }; svg.setPointerCapture(event.pointerId); event.preventDefault(); svg.focus({ preventScroll: true }); }
  });
  svg.addEventListener("pointerup", event => {
    if (!drag) return;
    const { panel, from, box } = drag, to = place(event), held = (v, a, b) => Math.min(Math.max(v, a), b);
    box?.remove();
    drag = null;
    const end = [held(to[0], panel.left, panel.right), held(to[1], panel.top, panel.bottom)];
    if (Math.abs(end[0] - from[0]) < 5 || Math.abs(end[1] - from[1]) < 5) return;
    const a = back(panel, from), b = back(panel, end);
    zoom(panel, [Math.min(a[0], b[0]), Math.min(a[1], b[1])], [Math.max(a[0], b[0]), Math.max(a[1], b[1])]);
  });
  // What a touch showed stays.
  svg.addEventListener("pointerleave", event => { if (!drag && event.pointerType === "mouse") { at = null; show(); } });
  svg.addEventListener("dblclick", () => zoom(null));
  svg.addEventListener("keydown", event => {
    const key = event.key, step = event.shiftKey ? 10 : 1;
    if (!["ArrowLeft", "ArrowRight", "ArrowUp", "ArrowDown", "+", "-", "Escape"].includes(key)) return;
    event.preventDefault();
    if (key === "Escape") { at = null; zoom(null); return; }
    at = at || { series: 0, point: 0 };
    const { panel, points } = series[at.series], here = points[at.point];
    if (key === "+" || key === "-") {
      const v = panel.view || whole(panel), f = key === "+" ? .5 : 2;
      const part = (low, high, c, a, b) => { const half = .5 * f * (high - low); return [Math.max(a, c - half), Math.min(b, c + half)]; };
      const [left, right] = part(v.left, v.right, here[0], panel.left, panel.right), [top, bottom] = part(v.top, v.bottom, here[1], panel.top, panel.bottom);
      const all = right - left > .99 * (panel.right - panel.left) && bottom - top > .99 * (panel.bottom - panel.top);
      zoom(all ? null : panel, [left, top], [right, bottom]);
      return;
    }
    if (key === "ArrowLeft" || key === "ArrowRight") {
      at.point = Math.min(Math.max(at.point + (key === "ArrowRight" ? step : -step), 0), points.length - 1);
    } else {
      const next = (at.series + (key === "ArrowDown" ? 1 : series.length - 1)) % series.length;
      let best = 0;
      series[next].points.forEach((p, j) => { if (Math.abs(p[0] - here[0]) < Math.abs(series[next].points[best][0] - here[0])) best = j; });
      at = { series: next, point: best };
    }
    show();
  });
}
