"use strict";
const at = (id) => document.getElementById(id);
const page = document.body.dataset.page;
const say = (id, text) => { const e = at(id); if (e.textContent !== text) e.textContent = text; };
const number = (v, digits) => (v === null || v === undefined ? "–" : v.toFixed(digits));
let quiet = 0;

function post(where, more) {
  return fetch(where, { method: "POST", body: new URLSearchParams({ page, ...more }) });
}

async function act(where) {
  try {
    const answer = await post(where);
    if (answer.status === 409) say("reason", "Another page holds the bench: it may be stopped from here, and started from there.");
  } catch (e) {
    say("reason", "The program does not answer.");
  }
}

for (const id of ["start", "mounted", "stop"]) {
  at(id).form.addEventListener("submit", (event) => { event.preventDefault(); act("/" + id); });
}
const faults = document.querySelector(".faults");
if (faults) faults.addEventListener("submit", (event) => { event.preventDefault(); post("/fault", { fault: faults.elements.fault.value }); });

document.addEventListener("keydown", (event) => {
  if (event.key === "Escape") { act("/stop"); return; }
  if (event.ctrlKey || event.metaKey || event.altKey || event.target.closest("input, select")) return;
  const button = { s: at("start"), m: at("mounted") }[event.key.toLowerCase()];
  if (button && !button.disabled) act("/" + button.id);
});

function words(view) {
  const measuring = { recording: "Recording", fading: "Fading" }[view.doing] || "Levelling";
  return { ready: "Ready", mounting: "Mount the device", measuring, paused: "Paused", finished: "Finished" }[view.phase];
}

function rows(id, list) {
  const body = at(id);
  const text = JSON.stringify(list);
  if (body.dataset.shown === text) return;
  body.dataset.shown = text;
  body.replaceChildren(...list.map((cells) => {
    const row = document.createElement("tr");
    for (const cell of cells) row.insertCell().textContent = cell;
    return row;
  }));
}

function seat(run) {
  if (!run) return "";
  const angles = run.inclination === null ? "" : ` · inclination ${run.inclination}°, rotation ${run.rotation}°`;
  return `${run.name}${angles}`;
}

function show(view) {
  const phase = words(view);
  say("phase", phase);
  at("phase").className = phase.split(" ")[0].toLowerCase();
  say("reason", view.reason || "");
  at("alarm").hidden = !view.alarm;
  say("alarm", view.alarm || "");
  const run = view.run;
  const measuring = view.phase === "measuring";
  at("start").disabled = !(view.phase === "ready" || view.phase === "paused");
  at("mounted").disabled = at("mounted").form.hidden = view.phase !== "mounting";
  at("stop").disabled = !(measuring || view.phase === "mounting");
  say("acceleration", measuring ? number(view.acceleration, 3) : "–");
  const busy = run && view.phase !== "finished";
  say("target", busy ? String(run.target) : "–");
  say("frequency", busy ? String(run.frequency) : "–");
  say("drive", number(view.drive, 4));
  say("mounting", view.phase === "finished" || view.phase === "ready" ? "" : seat(run));
  at("progress").value = view.done + (view.doing === "recording" ? view.recorded_share : 0);
  say("count", `${view.done} of ${view.total} runs`);
  say("note", view.result_note || (view.result ? `Of ${view.result.runs} runs.` : "The result comes when the runs determine it."));
  rows("result", view.result ? view.result.rows : []);
  rows("runs", view.recorded.map((r) => [r.name, String(r.frequency), r.level.toFixed(3),
    ((100 * (r.level / r.target - 1)).toFixed(2) + " %").replace("-", "−"), r.settling.toFixed(1) + " s"]));
  draw(view);
}

/* Each channel has a strip of its own, with its name and its largest value. */
function draw(view) {
  const canvas = at("curves");
  const scale = window.devicePixelRatio || 1;
  const width = Math.max(300, canvas.clientWidth), height = Math.max(200, canvas.clientHeight);
  canvas.width = width * scale; canvas.height = height * scale;
  const pen = canvas.getContext("2d");
  pen.scale(scale, scale);
  const style = getComputedStyle(document.documentElement);
  const [ink, faint, line, go] = ["--ink", "--faint", "--line", "--go"].map((n) => style.getPropertyValue(n));
  const left = 120, bottom = 26;
  const strip = (height - bottom) / Math.max(1, view.curves.length);
  pen.font = "17px system-ui, sans-serif";
  view.curves.forEach((curve, k) => {
    const middle = strip * (k + 0.5);
    const count = curve.low.length;
    if (count === 0) return;
    const low = Math.min(...curve.low), high = Math.max(...curve.high);
    const centre = (low + high) / 2, half = Math.max((high - low) / 2, 1e-4);
    const y = (v) => middle - (v - centre) / half * strip * 0.42;
    pen.strokeStyle = line; pen.lineWidth = 1;
    pen.beginPath(); pen.moveTo(left, middle); pen.lineTo(width, middle); pen.stroke();
    pen.fillStyle = ink; pen.fillText(curve.name, 4, middle - 3);
    pen.fillStyle = faint; pen.fillText("±" + half.toPrecision(3) + " V", 4, middle + 17);
    pen.strokeStyle = go; pen.lineWidth = 1.6;
    pen.beginPath();
    for (let i = 0; i < count; i++) {
      const x = left + (width - left) * i / Math.max(1, count - 1);
      if (i === 0) pen.moveTo(x, y(curve.low[i])); else pen.lineTo(x, y(curve.low[i]));
      pen.lineTo(x, y(curve.high[i]));
    }
    pen.stroke();
  });
  pen.fillStyle = faint;
  pen.fillText((1000 * view.seconds).toFixed(0) + " ms", width - 80, height - 6);
}

show(JSON.parse(document.body.dataset.view));
const stream = new EventSource("/events");
stream.onmessage = (event) => {
  quiet = 0;
  post("/beat").catch(() => {});
  show(JSON.parse(event.data));
};
setInterval(() => {
  quiet += 1;
  if (quiet > 3) {
    say("phase", "No answer");
    at("phase").className = "paused";
    say("reason", "The program does not answer. If it was started anew, open the link that it printed.");
  }
}, 1000);
