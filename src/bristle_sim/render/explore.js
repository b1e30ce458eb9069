// The bench: knobs on the left, the run that the server computed for them on the right. The address holds the state.
const keys = JSON.parse(document.getElementById("keys").textContent);
const el = (id) => document.getElementById(id);
const make = (tag, text = "", attributes = {}) => {
  const node = document.createElement(tag); node.textContent = text;
  for (const [name, value] of Object.entries(attributes)) node.setAttribute(name, value);
  return node;
};
const client = crypto.getRandomValues(new Uint32Array(2)).join("-"); // whose earlier, outdated run the server may stop
const knobs = new Map();
let shown = null, pinned = null, waiting = false, again = false;

// Knobs

const typed = (key, value) => value === null ? "" : key.choices || !key.unit || key.unit === "deg" ? String(value) : `${value} ${key.unit}`;
function sliderRange(key) { // a third to three times the value at the beginning; about zero a usual range
  const start = key.start, [low, high] = key.limits;
  if (start === 0) return key.unit === "deg" ? [low, high] : [low, Math.min(high, 1)];
  return [Math.max(low, Math.min(start / 3, 3 * start)), Math.min(high, Math.max(start / 3, 3 * start))];
}
function addKnob(key, group) {
  const box = make("div", "", { class: "knob" }), label = make("label"), line = make("div", "", { class: "row" }), id = "knob-" + key.key;
  label.append(make("span", key.label), make("span", key.unit === "deg" ? "°" : key.unit));
  label.setAttribute("for", id);
  let text;
  if (key.choices) {
    text = make("select", "", { id });
    for (const each of key.choices) text.append(make("option", each, { value: each }));
  } else {
    text = make("input", "", { id, type: "text", spellcheck: "false", autocomplete: "off" });
    if (key.start !== null) {
      const [low, high] = sliderRange(key);
      const slider = make("input", "", { type: "range", min: low, max: high, step: key.whole ? 1 : (high - low) / 300, "aria-label": key.label + ", slider" });
      slider.addEventListener("input", () => { text.value = typed(key, Number(Number(slider.value).toPrecision(5))); changed(); });
      line.append(slider); key.slider = slider;
    } else text.placeholder = "none";
  }
  text.addEventListener("change", () => { place(key, text); changed(); });
  line.append(text);
  box.append(label, line, make("p", `${key.meaning}; ${key.range}. Default: ${key.source}.`, { id: id + "-meaning" }));
  for (const each of [text, key.slider]) each?.setAttribute("aria-describedby", id + "-meaning");
  group.append(box);
  knobs.set(key.key, { key, text, box });
}
function place(key, text) { // the slider where the text is, if the text is a number in the unit shown
  const value = parseFloat(text.value), own = text.value.replace(/^[\d.eE+\-\s]+/, "");
  if (key.slider && !Number.isNaN(value) && (own === "" ? key.unit === "" || key.unit === "deg" : own === key.unit)) key.slider.value = value;
}
function holds(needs) { // whether a condition "KEY = VALUE" or "KEY != VALUE" is true of the knobs
  if (!needs) return true;
  const [name, relation, value] = needs.split(" "), knob = knobs.get(name);
  if (value === "none") return (knob.text.value.trim() === "") === (relation === "=");
  const same = knob.key.choices ? knob.text.value === value : parseFloat(knob.text.value) === parseFloat(value);
  return same === (relation === "=");
}
for (const title of new Set(keys.map((key) => key.group))) {
  const group = make("details"), own = keys.filter((key) => key.group === title);
  group.open = own.some((key) => key.open);
  group.append(make("summary", title));
  own.forEach((key) => addKnob(key, group));
  el("knobs").append(group);
}
const assigned = () => { // the knobs that differ from the beginning and have an effect
  const query = new URLSearchParams();
  for (const [name, { key, text }] of knobs) {
    if (holds(key.needs) && text.value.trim() !== typed(key, key.start)) query.set(name, text.value.trim());
  }
  return query;
};
function setKnobs(query) {
  for (const [name, { key, text }] of knobs) { text.value = query.get(name) ?? typed(key, key.start); place(key, text); }
}

// Asking the server: one request at a time, and the latest state after it

async function changed() {
  const query = assigned(), state = new URLSearchParams(query);
  if (pinned) state.set("pin", pinned.query);
  history.replaceState(null, "", state.size ? "?" + state : location.pathname);
  for (const [name, { key, text, box }] of knobs) {
    box.classList.toggle("changed", query.has(name));
    for (const each of [text, key.slider]) if (each) each.disabled = !holds(key.needs);
  }
  if (waiting && !slow) { again = true; return; }
  await ask(query);
}
let slow = false, newest = 0;
async function ask(query) {
  const number = ++newest, asked = String(query);
  waiting = true;
  const timer = setTimeout(() => { slow = true; say("computing; the last picture stays until it is done"); }, 300);
  try {
    const response = await fetch("run?" + asked, { headers: { "X-Client": client } });
    const found = await response.json();
    if (number === newest) found.error ? say(found.error, true) : show({ ...found, query: asked });
  } catch { if (number === newest) say("the server does not answer; start bristle-sim explore again", true); }
  clearTimeout(timer);
  if (number === newest) { waiting = slow = false; if (again) { again = false; await ask(assigned()); } }
}
function say(text, wrong = false) { el("status").textContent = text; el("status").classList.toggle("wrong", wrong); }

// Showing a run

function show(run) {
  shown = run;
  say(run.warnings.join(" "));
  for (const [name, { key }] of knobs) { // also a value that was typed in another unit
    if (key.slider && document.activeElement !== key.slider) key.slider.value = run.values[name];
  }
  el("answer").textContent = run.answer;
  el("command").textContent = run.command;
  viewer.show(run.motion);
  panels(run);
  table(run);
  el("remarks").replaceChildren(...run.remarks.map((each) => make("p", each, { class: "remarks" })));
  const rows = run.changed.map(([key, from, to]) => row([key, `${from} → ${to}`]));
  el("changed").replaceChildren(...(rows.length ? rows : [row(["nothing", ""])]));
  for (const link of document.querySelectorAll("#downloads a")) link.href = `download/${link.dataset.kind}?${run.query}`;
  document.body.dataset.shown = run.query;
}
const row = (cells, tag = "td") => { const node = make("tr"); cells.forEach((cell) => node.append(make(tag, cell))); return node; };
function table(run) {
  const [head, ...rows] = run.table;
  const other = new Map((pinned?.table ?? []).map(([label, unit, value]) => [label, { unit, value }]));
  const pinnedValue = ([label, unit]) => { const own = other.get(label); return !own ? "" : own.unit === unit ? own.value : `${own.value} ${own.unit}`; };
  el("head").replaceChildren(row(pinned ? [...head.slice(0, 2), "pinned", ...head.slice(2)] : head, "th"));
  el("rows").replaceChildren(...rows.map((cells) => row(pinned ? [...cells.slice(0, 2), pinnedValue(cells), ...cells.slice(2)] : cells)));
}
const PANELS = [["retraction", "retraction, °"], ["rate", "rate relative to the hub, rad/s"], ["speed", "tip speed, m/s"], ["force", "normal force on the wire, N"]];
for (const [name, caption] of PANELS) {
  const figure = make("figure");
  figure.append(make("canvas", "", { id: "panel-" + name, role: "img", "aria-label": caption + " over time" }), make("figcaption"));
  el("panels").append(figure);
}
function panels(run) {
  for (const [name, caption] of PANELS) {
    const canvas = el("panel-" + name);
    canvas.nextSibling.textContent = caption + `, over time in ms; ${run.series.drawn}` + (pinned ? "; grey: the pinned tool" : "");
    chart(canvas, [pinned && { ...pinned.series, values: pinned.series[name], colour: "soft" }, { ...run.series, values: run.series[name], colour: "wire" }].filter(Boolean));
  }
}
function ticks(low, high) {
  const raw = (high - low) / 5, power = 10 ** Math.floor(Math.log10(raw)), step = [1, 2, 5, 10].find((each) => each * power >= raw) * power;
  const found = [];
  for (let value = Math.ceil(low / step) * step; value <= high + 1e-9 * step; value += step) found.push(Number(value.toPrecision(12)));
  return found;
}
function chart(canvas, lines) {
  const ratio = window.devicePixelRatio || 1, width = canvas.clientWidth, height = canvas.clientHeight;
  if (!width) return;
  canvas.width = width * ratio; canvas.height = height * ratio;
  const pen = canvas.getContext("2d"), style = getComputedStyle(document.documentElement), colour = (name) => style.getPropertyValue("--" + name).trim();
  let [low, high] = [Math.min(...lines.map((each) => Math.min(...each.values))), Math.max(...lines.map((each) => Math.max(...each.values)))];
  if (!(high > low)) { low -= 1; high += 1; }
  const [first, last] = [Math.min(...lines.map((each) => each.time[0])), Math.max(...lines.map((each) => each.time.at(-1)))];
  pen.scale(ratio, ratio); pen.font = "11px system-ui, sans-serif";
  const labels = ticks(low, high), left = 10 + Math.max(...labels.map((each) => pen.measureText(String(each)).width));
  const X = (t) => left + (width - left - 8) * (t - first) / (last - first || 1), Y = (v) => height - 18 - (height - 28) * (v - low) / (high - low);
  pen.fillStyle = colour("soft"); pen.strokeStyle = colour("line"); pen.lineWidth = 1;
  pen.textAlign = "right";
  for (const each of labels) { pen.beginPath(); pen.moveTo(left, Y(each)); pen.lineTo(width - 8, Y(each)); pen.stroke(); pen.fillText(String(each), left - 5, Y(each) + 4); }
  pen.textAlign = "center";
  for (const each of ticks(first, last)) if (X(each) < width - 14) pen.fillText(String(each), X(each), height - 4);
  for (const { time, values, colour: name } of lines) {
    pen.beginPath(); pen.strokeStyle = colour(name); pen.lineWidth = name === "wire" ? 2 : 1.5;
    values.forEach((value, k) => pen.lineTo(X(time[k]), Y(value)));
    pen.stroke();
  }
}

// Buttons

el("pin").onclick = () => {
  pinned = pinned ? null : shown;
  el("pin").textContent = pinned ? "unpin" : "pin";
  changed(); if (shown) { panels(shown); table(shown); }
};
el("reset").onclick = () => { setKnobs(new URLSearchParams()); changed(); };
el("radial").onclick = async () => {
  say("searching the bar's place");
  const found = await (await fetch("radial?" + assigned(), { headers: { "X-Client": client } })).json();
  if (found.error) { say(found.error, true); return; }
  const query = assigned();
  for (const [name, value] of Object.entries(found.assignments)) query.set(name, value);
  setKnobs(query); changed();
};
window.addEventListener("resize", () => { if (shown) panels(shown); });
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => { if (shown) panels(shown); });
(async () => { // the state in the address
  const query = new URLSearchParams(location.search), pin = query.get("pin");
  query.delete("pin");
  const unknown = [...query.keys()].filter((name) => !knobs.has(name));
  if (pin !== null) {
    const found = await (await fetch("run?" + pin)).json();
    if (!found.error) { pinned = { ...found, query: pin }; el("pin").textContent = "unpin"; }
  }
  setKnobs(query);
  await changed();
  if (unknown.length) say(`unknown key ${unknown.join(", ")} in the address; the other keys are used`, true);
})();
