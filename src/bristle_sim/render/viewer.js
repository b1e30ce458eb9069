// The motion of a run under a slider: viewer.show(motion) shows one, and may be called again with another; a second motion is drawn
// beside it. The phase that is followed is shown in every run, until the slider is moved.
const viewer = (() => {
const find = (id) => document.getElementById(id), canvas = find("tool"), slider = find("instant");
let data, other, first, last, box, instant; // instant: the one shown, ms
let held = false, ghost = null; // while a part is dragged, and the part
let onPlot = null; // scale and origin of the drawing
const own = { onInstant: () => {}, followed: "" };

const BEFORE = 1e-6; // of a strike, its instant is shown, ms
const PLAYED = 8000; // steps of the slider, a millisecond each when it plays
function instantOf(step) { return step >= PLAYED ? last : first + (last - first) * step / PLAYED; } // rounding would show a jam before it
function showAt(t) { instant = Math.min(Math.max(t, first), last); slider.value = PLAYED * (instant - first) / (last - first); draw(); }
function sampleBefore(data, t) { // the last sample that is not after t, and not the last one of all
  let low = 0, high = data.time.length - 1;
  while (high - low > 1) { const middle = (low + high) >> 1; if (data.time[middle] <= t) low = middle; else high = middle; }
  return low;
}
function stateAt(data, t) { // cubics through positions and velocities at the nodes on either side, forces linear
  const i = sampleBefore(data, t), h = data.time[i + 1] - data.time[i], s = h > 0 ? (t - data.time[i]) / h : 1;
  const [a, b, c, d] = [2*s**3 - 3*s**2 + 1, s**3 - 2*s**2 + s, 3*s**2 - 2*s**3, s**3 - s**2];
  const [da, db, dd] = [6*s**2 - 6*s, 3*s**2 - 4*s + 1, 3*s**2 - 2*s];
  const [p, q, v, w] = [data.line[i], data.line[i + 1], data.velocity[i], data.velocity[i + 1]];
  const line = p.map((_, k) => a*p[k] + b*h*v[k] + c*q[k] + d*h*w[k]);
  const tipVelocity = [p.length - 2, p.length - 1].map((k) => h > 0 ? da*(p[k] - q[k])/h + db*v[k] + dd*w[k] : w[k]);
  const [one, other] = [data.retraction[i], data.retraction[i + 1]];
  return { line, tip: line.slice(-2), speed: Math.hypot(...tipVelocity), hub: data.hub[0] + data.hub[1] * (t - data.time[0]),
    retraction: a*one[0] + b*h*one[1] + c*other[0] + d*h*other[1],
    force: data.force[i][0] + s * (data.force[i + 1][0] - data.force[i][0]) };
}
function touching(t) { // the contact at an instant; one that takes no time is shown for a hundredth of the run
  t += 2 * BEFORE;
  const lasting = data.contacts.findLast((each) => each[2] > 0 && t >= each[1] && t <= each[1] + each[2]);
  return lasting ?? data.contacts.findLast((each) => each[2] === 0 && t >= each[1] && t <= each[1] + 0.01 * (last - first));
}
function boxShown() { // what the drawing shows, mm
  const xs = [], ys = [];
  for (const line of data.line) line.forEach((value, k) => (k % 2 ? ys : xs).push(value));
  if (data.bar) { const [x, y, r] = data.bar; xs.push(x - r, x + r); ys.push(y - r, y + r); }
  ys.push((data.surface ?? Math.min(...ys)) - 4, Math.max(...ys) + 4); xs.push(Math.min(...xs) - 4, Math.max(...xs) + 4);
  return [Math.min(...xs), Math.max(...xs), Math.min(...ys), Math.max(...ys)];
}

function draw() {
  const t = instant, now = stateAt(data, t), contact = touching(t);
  const ratio = window.devicePixelRatio || 1, width = canvas.clientWidth, height = canvas.clientHeight;
  canvas.width = width * ratio; canvas.height = height * ratio;
  const pen = canvas.getContext("2d"), style = getComputedStyle(document.documentElement);
  const colour = (name) => style.getPropertyValue("--" + name).trim();
  const scale = Math.min(width / (box[1] - box[0]), height / (box[3] - box[2]));
  const X = (x) => width / 2 + scale * (x - (box[0] + box[1]) / 2), Y = (y) => height / 2 - scale * (y - (box[2] + box[3]) / 2);
  onPlot = { scale, x: X(0), y: Y(0) };
  pen.scale(ratio, ratio); pen.lineJoin = pen.lineCap = "round"; pen.font = "13px system-ui, sans-serif";
  const path = (points, name, thick, dash = []) => {
    pen.beginPath(); pen.setLineDash(dash); pen.strokeStyle = colour(name); pen.lineWidth = thick;
    for (let k = 0; k < points.length; k += 2) pen.lineTo(X(points[k]), Y(points[k + 1]));
    pen.stroke(); pen.setLineDash([]);
  };
  const disc = (x, y, r, name) => { pen.beginPath(); pen.arc(X(x), Y(y), r, 0, 7); pen.fillStyle = colour(name); pen.fill(); };
  const word = (text, x, y) => { pen.fillStyle = colour("ink"); pen.textAlign = "center"; pen.fillText(text, x, y); };
  const arrow = (x, y, dx, dy) => {
    const size = Math.hypot(dx, dy), reach = Math.min(0.16 * height, 70) / scale, [u, v] = [dx / size * reach, dy / size * reach];
    path([x - u, y - v, x, y], "force", 3);
    path([x - 0.25*u - 0.15*v, y - 0.25*v + 0.15*u, x, y, x - 0.25*u + 0.15*v, y - 0.25*v - 0.15*u], "force", 3);
  };
  disc(0, 0, scale * data.hubRadius, "line");
  for (let k = 0; k < 12; k++) { // roots of further bristles show the hub's turn
    const angle = now.hub + k * Math.PI / 6;
    disc(data.hubRadius * Math.sin(angle), -data.hubRadius * Math.cos(angle), 2.5, "soft");
  }
  if (Y(0) > 20 && Y(0) < height) word("hub", Math.min(Math.max(X(0), 24), width - 24), Y(0));
  if (data.surface !== null) {
    pen.fillStyle = colour("metal"); pen.fillRect(0, Y(data.surface), width, height); word("workpart", 42, Y(data.surface) + 18);
  }
  if (data.bar) { disc(data.bar[0], data.bar[1], scale * data.bar[2], "metal"); word("bar", X(data.bar[0]), Y(data.bar[1]) + 4); }
  const ring = (x, y, r, name) => { pen.beginPath(); pen.arc(X(x), Y(y), scale * r, 0, 7); pen.strokeStyle = colour(name); pen.setLineDash([4, 3]); pen.stroke(); pen.setLineDash([]); };
  const trail = (of, end) => { // the tip's path
    const start = of.time[0], points = [];
    for (let k = 0; k <= 400; k++) points.push(...stateAt(of, start + (end - start) * k / 400).tip);
    return points;
  };
  let then = null;
  if (other) { // the other tool's motion at the same instant
    then = stateAt(other, Math.min(t, other.time.at(-1)));
    path(trail(other, other.time.at(-1)), "soft", 1, [2, 3]); path(then.line, "soft", Math.max(2, scale * other.wire));
    if (other.bar) ring(...other.bar, "soft");
    if (other.surface !== null) path([box[0], other.surface, box[1], other.surface], "soft", 1, [4, 3]);
  }
  if (ghost) ghost.length > 1 ? ring(...ghost, data.bar[2], "force") : path([box[0], ghost[0], box[1], ghost[0]], "force", 1, [4, 3]);
  path(trail(data, last), "trail", 1, [1, 4]); path(trail(data, t), "trail", 2);
  const root = now.line.slice(0, 2), outward = 1 + 0.98 * Math.hypot(now.tip[0] - root[0], now.tip[1] - root[1]) / data.hubRadius;
  if (data.hubRadius > 0) path([...root, root[0] * outward, root[1] * outward], "soft", 1, [5, 4]);
  path(now.line, "wire", Math.max(2, scale * data.wire)); disc(...root, 4, "wire");
  let force = "none";
  if (contact) {
    const [obstacle, , duration, normal, tangential, digit] = contact; // digit: the last one of the force that is exact, N
    const newtons = (Math.round(now.force / digit) * digit).toFixed(Math.max(0, Math.round(-Math.log10(digit))));
    const brief = duration === 0, amount = brief ? `impulse ${normal.toFixed(3)} mN s` : `${newtons} N`;
    force = `${amount} by the ${obstacle}`;
    if (obstacle === "workpart") { // an impulse with its friction; the tangent runs along x
      if (brief || now.force > 0) arrow(now.tip[0], now.tip[1], brief ? tangential : 0, brief ? normal : 1);
    } else if (data.bar && (brief || now.force > 0)) { // where the wire is nearest to the bar
      let best = [Infinity, 0, 0];
      for (let k = 0; k + 3 < now.line.length; k += 2) {
        const [x, y, x2, y2] = now.line.slice(k, k + 4), [u, v] = [x2 - x, y2 - y];
        const s = Math.min(1, Math.max(0, ((data.bar[0] - x) * u + (data.bar[1] - y) * v) / (u * u + v * v)));
        const gap = Math.hypot(x + s * u - data.bar[0], y + s * v - data.bar[1]);
        if (gap < best[0]) best = [gap, x + s * u, y + s * v];
      }
      arrow(best[1], best[2], best[1] - data.bar[0], best[2] - data.bar[1]);
    }
  }
  const bar = 10 * scale, edge = width - 14; // the scale, bottom right: clear of the wire, which turns above the workpart
  pen.fillStyle = colour("ink"); pen.fillRect(edge - bar, height - 10, bar, 2); word("10 mm", edge - bar / 2, height - 16);
  find("now-time").textContent = `${t.toFixed(3)} ms`;
  find("now-phase").textContent = data.phases.findLast((each) => each[0] <= t + (each[1] === "strike" ? 2 * BEFORE : 1e-9))?.[1] ?? "";
  const beside = (one, two, digits) => then ? ` (${one < two ? "" : "+"}${(one - two).toFixed(digits)})` : ""; // the difference to the other tool
  find("now-retraction").textContent = `${now.retraction.toFixed(2)}°${beside(now.retraction, then?.retraction, 2)}`;
  find("now-tip").textContent = `${now.tip[0].toFixed(2)}, ${now.tip[1].toFixed(2)} mm`;
  find("now-speed").textContent = `${now.speed.toFixed(1)} m/s${beside(now.speed, then?.speed, 1)}`;
  find("now-force").textContent = force;
  canvas.setAttribute("aria-label", `Hub, wire, bar and workpart at ${find("now-time").textContent}: ${find("now-phase").textContent}, ` +
    `retraction ${find("now-retraction").textContent}, force ${force}`);
  own.onInstant(t);
}
let playing = 0, began = 0;
function advance(now) { // the whole run in eight seconds
  own.followed = "";
  slider.value = Math.min(slider.max, now - began); instant = instantOf(Number(slider.value)); draw();
  playing = Number(slider.value) < Number(slider.max) ? requestAnimationFrame(advance) : 0;
  find("play").textContent = playing ? "pause" : "play";
}
find("play").onclick = () => {
  if (playing) { cancelAnimationFrame(playing); playing = 0; find("play").textContent = "play"; return; }
  if (Number(slider.value) >= Number(slider.max)) slider.value = 0;
  began = performance.now() - slider.value;
  advance(performance.now());
};
own.show = (motion, beside = null) => {
  const fresh = data === undefined;
  data = motion; other = beside;
  [first, last] = [data.time[0], data.time[data.time.length - 1]];
  slider.max = PLAYED;
  instant = instantOf(Number(slider.value));
  if (!held) { box = boxShown(); ghost = null; }
  find("drawn").textContent = data.drawn;
  const named = new Map(); // the first phase of each caption
  for (const [start, caption] of data.phases.slice(1)) if (!named.has(caption)) named.set(caption, start - (caption === "strike" ? BEFORE : 0));
  find("jumps").replaceChildren(find("play"));
  for (const [caption, start] of named) {
    const jump = document.createElement("button");
    jump.type = "button"; jump.textContent = caption; find("jumps").append(jump);
    jump.onclick = () => { showAt(start); own.followed = caption; };
  }
  if (fresh) {
    slider.addEventListener("input", () => { own.followed = ""; instant = instantOf(Number(slider.value)); draw(); });
    window.addEventListener("resize", draw);
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", draw);
  }
  const place = [...named].find(([caption]) => own.followed && caption.startsWith(own.followed));
  place ? showAt(place[1]) : draw();
};
own.showAt = (t) => { own.followed = ""; showAt(t); };
own.place = (event) => { // of the pointer, mm, and the part that is there
  const { left, top } = canvas.getBoundingClientRect(), x = (event.clientX - left - onPlot.x) / onPlot.scale, y = (onPlot.y - event.clientY + top) / onPlot.scale;
  const near = 6 / onPlot.scale, onBar = data.bar && Math.hypot(x - data.bar[0], y - data.bar[1]) < data.bar[2] + near;
  return { x, y, part: onBar ? "bar" : data.surface !== null && y < data.surface + near ? "workpart" : "" };
};
own.hold = (is, part = null) => { held = is; ghost = part; draw(); };
return own;
})();
