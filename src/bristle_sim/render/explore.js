// The bench: knobs on the left, the run that the server computed for them on the right. The address holds the state.
const keys = JSON.parse(document.getElementById("keys").textContent);
const el = (id) => document.getElementById(id);
const make = (tag, text = "", attributes = {}) => {
  const node = document.createElement(tag); node.textContent = text;
  for (const [name, value] of Object.entries(attributes)) node.setAttribute(name, value);
  return node;
};
const client = crypto.getRandomValues(new Uint32Array(2)).join("-"); // whose earlier, outdated run the server may stop
const get = async (path, part = "") => (await fetch(path, { headers: { "X-Client": client + part } })).json();
const knobs = new Map();
let shown = null, pinned = null, waiting = false, again = false;

// Knobs

const NUMBER = /^[+-]?(\d+\.?\d*|\.\d+)(e[+-]?\d+)?$/i;
const plain = (value, digits = 5) => String(Number(value.toPrecision(digits)));
const withUnit = (key, value, digits) => `${plain(value, digits)} ${key.unit}`.trim();
const unitShown = (unit) => unit === "deg" ? "°" : unit;
function sliderRange(key) { // a usual range, else a third to three times the value at the beginning
  const start = key.start, [low, high] = key.limits;
  if (key.slider.length) return [Math.min(start, key.slider[0]), Math.max(start, key.slider[1])];
  if (start === 0) return key.unit === "deg" ? [low, high] : [low, Math.min(high, 1)];
  return [Math.max(low, Math.min(start / 3, 3 * start)), Math.min(high, Math.max(start / 3, 3 * start))];
}
function setSlider(key, value) { if (key.range) key.range.value = key.key === "accuracy" ? Math.log10(value) : value; }
function addKnob(key, group) {
  const box = make("div", "", { class: "knob" }), label = make("label"), line = make("div", "", { class: "row" }), id = "knob-" + key.key;
  label.append(make("span", key.label), make("span", unitShown(key.unit)));
  label.setAttribute("for", id);
  let text;
  if (key.choices) {
    text = make("select", "", { id });
    for (const each of key.choices) text.append(make("option", each, { value: each }));
  } else {
    text = make("input", "", { id, type: "text", spellcheck: "false", autocomplete: "off" });
    if (key.start !== null) {
      const scale = key.key === "accuracy" ? Math.log10 : (value) => value, [low, high] = sliderRange(key).map(scale);
      key.range = make("input", "", { type: "range", min: low, max: high, step: key.whole ? 1 : (high - low) / 400, "aria-label": key.label + ", slider" });
      key.range.addEventListener("input", () => {
        const value = Number(key.range.value);
        text.value = key.key === "accuracy" ? withUnit(key, 10 ** value, 2) : withUnit(key, value); changed();
      });
      key.range.addEventListener("change", commit);
      line.append(key.range);
    } else text.placeholder = "none";
  }
  text.addEventListener("change", () => { // a bare number is in the unit that the field shows
    const own = key.optional && text.value.trim() === "none" ? "" : text.value.trim(); // the word that an empty field shows
    text.value = key.unit && NUMBER.test(own) ? `${own} ${key.unit}` : own;
    place(key, text); changed(); commit();
  });
  line.append(text);
  box.append(label, line, make("p", `${key.meaning}; ${key.between}. Default: ${key.source}.`, { id: id + "-meaning" }));
  for (const each of [text, key.range]) each?.setAttribute("aria-describedby", id + "-meaning");
  group.append(box);
  knobs.set(key.key, { key, text, box });
}
function place(key, text) { // the slider where the text is, if the text is a number in the unit shown
  const value = parseFloat(text.value), own = text.value.replace(/^[\d.eE+\-\s]+/, "");
  if (!Number.isNaN(value) && own === key.unit) setSlider(key, value);
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
  for (const [name, { key, text }] of knobs) if (holds(key.needs) && text.value.trim() !== key.text) query.set(name, text.value.trim());
  return query;
};
function setKnobs(query, others = "text") { // a bare number in an address is in SI units
  for (const [name, { key, text }] of knobs) {
    const value = query.get(name) ?? key[others];
    text.value = key.unit && NUMBER.test(value) ? withUnit(key, value / key.size, 9) : value;
    place(key, text);
  }
}
function turn(values) { // knobs to values in the units shown
  for (const [name, value] of Object.entries(values)) { const { key, text } = knobs.get(name); text.value = withUnit(key, value); place(key, text); }
  changed();
}

// The address: each finished move is an entry of the browser's history, which undo and redo step through

let at = history.state?.at ?? 0, newestEntry = at;
const address = () => { const state = assigned(); if (pinned) state.set("pin", pinned.query); return state.size ? "?" + state : location.pathname; };
function commit() {
  if (new URL(address(), location).href === location.href) return;
  history.pushState({ at: ++at }, "", address());
  newestEntry = at; steps();
}
function steps() { el("undo").disabled = at === 0; el("redo").disabled = at >= newestEntry; }
el("undo").onclick = () => history.back();
el("redo").onclick = () => history.forward();
window.addEventListener("popstate", (event) => { at = event.state?.at ?? 0; steps(); restore(); });
async function restore() { // the state in the address
  const query = new URLSearchParams(location.search), pin = query.get("pin");
  query.delete("pin");
  const unknown = [...query.keys()].filter((name) => !knobs.has(name));
  setKnobs(query); document.body.dataset.state = "asking";
  if ((pinned?.query ?? null) !== pin) {
    const found = pin === null ? null : await get("run?" + pin, "-pin");
    pinned = found && !found.error ? { ...found, query: pin } : null;
    el("pin").textContent = pinned ? "unpin" : "pin";
  }
  await changed();
  if (unknown.length) say(`unknown key ${unknown.join(", ")} in the address; the other keys are used`, true);
}

// Asking the server: one request at a time, and the latest state after it

async function changed() {
  const query = assigned();
  if (String(answered.subject()) !== answered.query) el("found").textContent = "";
  document.body.dataset.state = "asking";
  for (const [name, { key, text, box }] of knobs) {
    box.classList.toggle("changed", query.has(name));
    for (const each of [text, key.range]) if (each) each.disabled = !holds(key.needs);
  }
  if (waiting && !slow) { again = true; return; }
  await ask(query);
}
let slow = false, newest = 0;
async function ask(query) {
  const number = ++newest, asked = String(query);
  waiting = true;
  const timer = setTimeout(() => { if (number === newest) { slow = true; say("computing; the picture is that of the last run"); watch(number); } }, 300);
  try {
    const found = await get("run?" + asked);
    if (number === newest) found.error ? refuse(found.error) : show({ ...found, query: asked });
  } catch { if (number === newest) refuse("the server does not answer; start bristle-sim explore again"); }
  clearTimeout(timer);
  if (number === newest) { waiting = slow = false; el("progress").hidden = true; if (again) { again = false; await ask(assigned()); } else document.body.dataset.state = "done"; }
}
async function watch(number) { // the fraction of a slow run that is done
  for (; number === newest && waiting; await new Promise((done) => setTimeout(done, 300))) {
    const found = await get("progress").catch(() => ({}));
    if (number !== newest || !waiting) return;
    el("progress").hidden = false;
    found.done ? el("progress").value = found.done : el("progress").removeAttribute("value");
  }
}
function say(text, wrong = false) { el("status").textContent = text; el("status").classList.toggle("wrong", wrong); }
function refuse(text) { say(text, true); el("result").classList.add("outdated"); redraw(false); }

// Showing a run

function show(run) {
  shown = run;
  say(run.warnings.join(" ")); el("result").classList.remove("outdated"); el("result").inert = false;
  for (const [name, { key }] of knobs) if (key.range && document.activeElement !== key.range) setSlider(key, run.values[name]); // also a value in another unit
  el("answer").textContent = run.answer;
  el("command").textContent = run.command;
  viewer.show(run.motion, pinned?.motion);
  table(run);
  el("remarks").replaceChildren(...run.remarks.map((each) => make("p", each, { class: "remarks" })));
  const rows = run.changed.map(([key, from, to]) => row([key, `${from} → ${to}`]));
  el("changed").replaceChildren(...(rows.length ? rows : [row(["nothing", ""])]));
  for (const link of document.querySelectorAll("#downloads a")) link.href = `download/${link.dataset.kind}?${run.query}`;
  document.body.dataset.shown = run.query;
  redraw(false); clearTimeout(surfaceTimer); surfaceTimer = setTimeout(showSurface, 200);
}
let surfaceTimer = 0;
async function showSurface() { // of the present tool, when the knobs rest
  const asked = shown?.query, picture = el("surface");
  if (!el("surface-box").open || asked === undefined || picture.dataset.asked === asked) return;
  picture.classList.add("outdated");
  const found = await get("surface?" + asked, "-surface").catch(() => ({ error: "the server does not answer" }));
  if (asked !== shown.query) return;
  picture.dataset.asked = asked; picture.hidden = !found.picture; el("surface-note").textContent = found.error ?? "";
  if (found.picture) { picture.src = "data:image/png;base64," + found.picture; picture.classList.remove("outdated"); }
}
el("surface-box").addEventListener("toggle", showSurface);
const row = (cells, tag = "td") => { const node = make("tr"); cells.forEach((cell) => node.append(make(tag, cell))); return node; };
function table(run) {
  const [head, ...rows] = run.table;
  const other = new Map((pinned?.table ?? []).slice(1).map(([label, unit, value], k) => [label, { unit, value, number: pinned.simulated[k] }]));
  const beside = ([label, unit], k) => { // the pinned tool's value, and the difference to it
    const own = other.get(label), number = run.simulated[k];
    if (!own) return ["", ""];
    const change = number === null || !own.number ? "" : 100 * (number - own.number) / Math.abs(own.number);
    return [own.unit === unit ? own.value : `${own.value} ${own.unit}`, change === "" ? "" : `${change > 0 ? "+" : ""}${plain(change, 3)} %`];
  };
  el("head").replaceChildren(row(pinned ? [...head.slice(0, 3), "pinned", "change", head[3]] : head, "th"));
  el("rows").replaceChildren(...rows.map((cells, k) => row(pinned ? [...cells.slice(0, 3), ...beside(cells, k), cells[3]] : cells)));
}
const PANELS = [ // curves at the instants of the motion, which has slopes per ms
  ["retraction", "retraction, °", ({ retraction }) => retraction.map(([value]) => value)],
  ["rate", "rate relative to the hub, rad/s", ({ retraction }) => retraction.map(([, slope]) => -1e3 * slope * Math.PI / 180)],
  ["speed", "tip speed, m/s", ({ velocity }) => velocity.map((each) => Math.hypot(...each.slice(-2)))],
  ["force", "normal force on the wire, N", ({ force }) => force.map(([value]) => value)],
];
for (const [name, caption] of PANELS) {
  const figure = make("figure"), canvas = make("canvas", "", { id: "panel-" + name, role: "img", "aria-label": caption + " over time" });
  figure.append(canvas, make("figcaption"));
  el("panels").append(figure);
  const seek = (event) => { const { left, width, first, last } = canvas.axis; if (event.buttons) viewer.showAt(first + (last - first) * (event.offsetX - left) / width); };
  canvas.addEventListener("pointerdown", seek); canvas.addEventListener("pointermove", seek);
}
function panels(t) {
  for (const [name, caption, curve] of shown ? PANELS : []) {
    const line = ({ motion, marks }, colour) => ({ time: motion.time, values: curve(motion), marks, colour });
    const canvas = el("panel-" + name);
    canvas.nextSibling.textContent = caption + ", over time in ms" + (pinned ? "; grey: the pinned tool" : "");
    chart(canvas, [...(pinned ? [line(pinned, "soft")] : []), line(shown, "wire")], t);
  }
}
viewer.onInstant = panels; viewer.followed = "strike";
function ticks(low, high) {
  const raw = (high - low) / 5, power = 10 ** Math.floor(Math.log10(raw)), step = [1, 2, 5, 10].find((each) => each * power >= raw) * power;
  const found = [];
  for (let value = Math.ceil(low / step) * step; value <= high + 1e-9 * step; value += step) found.push(Number(value.toPrecision(12)));
  return found;
}
function penOf(canvas) { // a pen in CSS pixels, and the colours of the page
  const ratio = window.devicePixelRatio || 1, width = canvas.clientWidth, height = canvas.clientHeight;
  canvas.width = width * ratio; canvas.height = height * ratio;
  const pen = canvas.getContext("2d"), style = getComputedStyle(document.documentElement);
  pen.scale(ratio, ratio); pen.font = "11px system-ui, sans-serif";
  return { pen, width, height, colour: (name) => style.getPropertyValue("--" + name).trim() };
}
function chart(canvas, lines, t) {
  if (!canvas.clientWidth) return;
  const { pen, width, height, colour } = penOf(canvas);
  let [low, high] = [Math.min(...lines.map((each) => Math.min(...each.values))), Math.max(...lines.map((each) => Math.max(...each.values)))];
  if (!(high > low)) { low -= 1; high += 1; }
  const [first, last] = [Math.min(...lines.map((each) => each.time[0])), Math.max(...lines.map((each) => each.time.at(-1)))];
  const labels = ticks(low, high), left = 10 + Math.max(...labels.map((each) => pen.measureText(String(each)).width));
  const X = (time) => left + (width - left - 8) * (time - first) / (last - first || 1), Y = (v) => height - 18 - (height - 42) * (v - low) / (high - low);
  canvas.axis = { left, width: width - left - 8, first, last };
  const upright = (time, name) => { pen.strokeStyle = colour(name); pen.beginPath(); pen.moveTo(X(time), 14); pen.lineTo(X(time), height - 18); pen.stroke(); };
  pen.fillStyle = colour("soft"); pen.strokeStyle = colour("line"); pen.lineWidth = 1;
  pen.textAlign = "right";
  for (const each of labels) { pen.beginPath(); pen.moveTo(left, Y(each)); pen.lineTo(width - 8, Y(each)); pen.stroke(); pen.fillText(String(each), left - 5, Y(each) + 4); }
  pen.textAlign = "center";
  for (const each of ticks(first, last)) if (X(each) < width - 14) pen.fillText(String(each), X(each), height - 4);
  const taken = []; // widths with an event's name; the strike comes first
  pen.setLineDash([2, 3]); pen.textAlign = "left"; pen.font = "10px system-ui, sans-serif";
  for (const [time, name] of [...lines.at(-1).marks].sort(([, one], [, two]) => (two === "strike") - (one === "strike"))) {
    upright(time, "soft");
    const size = pen.measureText(name).width + 6, x = Math.max(0, Math.min(X(time) - size / 2, width - size));
    if (taken.every((each) => Math.abs(each[0] + each[1] / 2 - x - size / 2) >= (each[1] + size) / 2)) { pen.fillText(name, x + 3, 11); taken.push([x, size]); }
  }
  pen.setLineDash([]); upright(t, "force");
  for (const { time, values, colour: name } of lines) {
    pen.beginPath(); pen.strokeStyle = colour(name); pen.lineWidth = name === "wire" ? 2 : 1.5;
    values.forEach((value, k) => pen.lineTo(X(time[k]), Y(value)));
    pen.stroke();
  }
}

// Bar and workpart dragged in the picture

{
  const canvas = el("tool");
  let grip = null; // the part, and its place less the pointer's
  canvas.addEventListener("pointerdown", (event) => {
    const { x, y, part } = viewer.place(event), { bar_horizontal, bar_vertical, penetration } = shown.values;
    if (!part) return;
    grip = { part, x: -bar_horizontal - x, y: part === "bar" ? -bar_vertical - y : shown.motion.surface - y, sum: penetration - shown.motion.surface };
    canvas.setPointerCapture(event.pointerId); event.preventDefault();
  });
  canvas.addEventListener("pointermove", (event) => {
    const { x, y, part } = viewer.place(event);
    canvas.style.cursor = part || grip ? "grab" : "";
    if (!grip) return;
    const [u, v] = [grip.x + x, grip.y + y];
    viewer.hold(true, grip.part === "bar" ? [u, v] : [v]);
    turn(grip.part === "bar" ? { bar_horizontal: -u, bar_vertical: -v } : { penetration: v + grip.sum });
  });
  for (const end of ["pointerup", "pointercancel"]) canvas.addEventListener(end, () => { if (grip) { grip = null; viewer.hold(false); changed(); commit(); } });
}

// The map behind the knobs: a quantity of the pass, or its outcome, over two keys

const COLOURS = [[68, 1, 84], [65, 68, 135], [42, 120, 142], [34, 168, 132], [122, 209, 81], [253, 231, 37]];
const OUTCOMES = [[86, 180, 233], [0, 114, 178], [0, 158, 115], [230, 159, 0], [213, 94, 0], [150, 155, 160], [205, 208, 212]];
const map = { of: "", zoom: 4, ranges: {}, found: null, asked: "", fine: false, busy: false, timer: 0 };
const axes = () => [el("map-x").value, el("map-y").value];
for (const [id, start] of [["map-x", "bar_horizontal"], ["map-y", "bar_vertical"]]) {
  for (const key of keys.filter((each) => each.mapped)) el(id).append(make("option", `${key.label}${key.unit && ", "}${unitShown(key.unit)}`, { value: key.key }));
  el(id).value = start;
  el(id).onchange = () => { map.zoom = axes().every((name) => name.startsWith("bar_")) ? 4 : 1; aim(); redraw(false); };
}
el("map-of").onchange = () => redraw(false);
for (const [id, factor] of [["closer", 2], ["wider", 0.5]]) el(id).onclick = () => { map.zoom = Math.max(1, map.zoom * factor); aim(); redraw(false); };
function aim() { // the part of the knobs' ranges that the map shows: about the present tool; the bar stands as in the picture
  for (const name of axes()) {
    const { key } = knobs.get(name), [low, high] = sliderRange(key), half = (high - low) / map.zoom / 2;
    const middle = Math.min(Math.max(shown.values[name], low + half), high - half);
    map.ranges[name] = name.startsWith("bar_") ? [middle + half, middle - half] : [middle - half, middle + half];
  }
}
const mapQuery = () => { // of the map: all knobs but its own two
  const query = assigned(), [x, y] = axes(), texts = (name) => [name, ...map.ranges[name].map((each) => withUnit(knobs.get(name).key, each, 12))];
  query.delete(x); query.delete(y);
  query.set("on", JSON.stringify({ x: texts(x), y: texts(y), of: el("map-of").value }));
  return query;
};
async function redraw(fine) { // coarse while knobs move, fine when they rest
  clearTimeout(map.timer);
  if (!el("map-box").open || !shown) return;
  const outside = axes().some((name) => !map.ranges[name] || shown.values[name] < Math.min(...map.ranges[name]) || shown.values[name] > Math.max(...map.ranges[name]));
  if (outside) aim();
  const query = mapQuery(), asked = String(query), sides = axes().map((name) => [name, map.ranges[name]]);
  el("map").classList.toggle("outdated", asked !== map.asked);
  if (map.busy) return;
  if (asked !== map.asked || fine) {
    map.busy = true;
    query.set("fine", Number(fine));
    const found = await get("map?" + query, "-map").catch(() => ({ error: "the server does not answer" }));
    Object.assign(map, { busy: false, found: { ...found, sides }, asked, fine });
    el("map-note").textContent = found.error ?? found.note;
    if (String(mapQuery()) !== asked) { redraw(false); return; }
  }
  drawMap();
  if (!map.fine) map.timer = setTimeout(() => redraw(true), 150);
}
const bytes = (text) => Uint8Array.from(atob(text), (each) => each.charCodeAt(0));
const shade = (fraction) => {
  const place = fraction * (COLOURS.length - 1), k = Math.min(Math.floor(place), COLOURS.length - 2);
  return COLOURS[k].map((each, n) => each + (place - k) * (COLOURS[k + 1][n] - each));
};
function drawMap() {
  const canvas = el("map"), { found } = map;
  canvas.classList.toggle("outdated", !found?.size || String(mapQuery()) !== map.asked);
  if (!canvas.clientWidth || !found?.size) return;
  const { pen, width, height, colour } = penOf(canvas), size = found.size, picture = new ImageData(size, size);
  found.values ??= bytes(found.shades); found.words ??= bytes(found.outcomes);
  for (let k = 0; k < size * size; k++) {
    const from = (size - 1 - Math.floor(k / size)) * size + k % size, value = found.values[from];
    picture.data.set([...(value === 255 ? OUTCOMES[found.words[from]] : shade(value / 254)), 255], 4 * k);
  }
  const sheet = make("canvas", "", { width: size, height: size });
  sheet.getContext("2d").putImageData(picture, 0, 0);
  const [[x, [x0, x1]], [y, [y0, y1]]] = found.sides, labels = ticks(...[y0, y1].sort((a, b) => a - b));
  const left = 10 + Math.max(...labels.map((each) => pen.measureText(String(each)).width)), wide = width - left - 10, high = height - 28;
  const X = (value) => left + wide * (value - x0) / (x1 - x0), Y = (value) => 8 + high * (y1 - value) / (y1 - y0);
  canvas.axis = { left, wide, high };
  pen.imageSmoothingEnabled = false; pen.drawImage(sheet, left, 8, wide, high);
  pen.fillStyle = colour("soft"); pen.textAlign = "right";
  for (const each of labels) pen.fillText(String(each), left - 5, Y(each) + 4);
  pen.textAlign = "center";
  for (const each of ticks(Math.min(x0, x1), Math.max(x0, x1))) pen.fillText(String(each), X(each), height - 6);
  for (const [ink, thick] of [["#000", 4], ["#fff", 2]]) {
    pen.beginPath(); pen.strokeStyle = ink; pen.lineWidth = thick; pen.arc(X(shown.values[x]), Y(shown.values[y]), 6, 0, 7); pen.stroke();
  }
  const chip = (text, [r, g, b]) => { const node = make("span", text); node.style.setProperty("--chip", `rgb(${r},${g},${b})`); return node; };
  const scale = make("span", `${found.low} to ${found.high}`, { class: "scale" });
  el("legend").replaceChildren(...(found.low ? [scale] : []), ...found.present.map((each) => chip(found.names[each], OUTCOMES[each])));
}
function onMap(event) { // the values of the two keys at the pointer
  const { left, wide, high } = el("map").axis, part = (value) => Math.min(1, Math.max(0, value)), [x, y] = map.found.sides;
  const [u, v] = [part((event.offsetX - left) / wide), part(1 - (event.offsetY - 8) / high)], between = ([low, high_], s) => low + s * (high_ - low);
  return { [x[0]]: between(x[1], u), [y[0]]: between(y[1], v) };
}
for (const kind of ["pointerdown", "pointermove"]) el("map").addEventListener(kind, (event) => { if (map.found?.size && event.buttons) { event.preventDefault(); turn(onMap(event)); } });
el("map").addEventListener("pointerup", commit);
el("map").addEventListener("keydown", (event) => {
  const [u, v] = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] }[event.key] ?? [0, 0];
  if (!u && !v) return;
  event.preventDefault();
  turn(Object.fromEntries(axes().map((name, k) => [name, shown.values[name] + [u, v][k] * (map.ranges[name][1] - map.ranges[name][0]) / 100])));
  commit();
});
el("map-box").addEventListener("toggle", () => redraw(false));

// Buttons

const answered = { subject: assigned, query: "" }; // the sentence of the last search
let searches = 0;
async function search(path, words, subject = assigned) { // subject: the knobs that the answer depends on
  const asked = String(subject()), number = ++searches;
  say(words);
  const found = await get(path, "-search").catch(() => ({ error: "the server does not answer" }));
  if (number !== searches || String(subject()) !== asked) return; // a newer search, or a knob has moved on
  if (found.error) { say(found.error, true); return; }
  const query = assigned();
  for (const [name, value] of Object.entries(found.assignments ?? {})) query.set(name, value);
  if (found.assignments) setKnobs(query); else say("");
  Object.assign(answered, { subject, query: String(subject()) });
  el("found").textContent = found.answer ?? "";
  if (found.assignments) { changed(); commit(); }
}
el("pin").onclick = () => {
  pinned = pinned ? null : shown;
  el("pin").textContent = pinned ? "unpin" : "pin";
  changed(); commit();
};
el("reset").onclick = () => { setKnobs(new URLSearchParams()); changed(); commit(); };
el("preset").onchange = () => { setKnobs(new URLSearchParams(el("preset").value), "preset"); el("preset").value = "-"; changed(); commit(); };
el("radial").onclick = () => search("radial?" + assigned(), "searching the bar's place");
el("limits").onclick = () => { // the second key of the map has its present value
  const query = assigned(), [x] = axes(), others = () => { const found = assigned(); found.delete(x); return found; };
  query.set("on", mapQuery().get("on"));
  search("limits?" + query, "searching the changes of the outcome", others);
};
el("design").onclick = () => {
  const query = mapQuery(), on = JSON.parse(query.get("on"));
  on.want = Object.fromEntries(["1", "2"].map((n) => [el("want-" + n).value, el("wanted-" + n).value.trim()]).filter(([, value]) => value));
  query.set("on", JSON.stringify(on));
  search("design?" + query, "searching the tool");
};
window.addEventListener("resize", drawMap);
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", drawMap);
history.replaceState({ at }, ""); steps();
restore();
