// What moves on the page: theme, plots with linked cursors, tables that sort, downloads, the 3-D views.
"use strict";
const read = id => { const e = document.getElementById(id); return e ? JSON.parse(e.textContent) : null; };
const all = (query, from = document) => [...from.querySelectorAll(query)];
const specs = read("specs"), colours = read("colours");

// --- theme ---------------------------------------------------------------------------------------------------------
const system = window.matchMedia("(prefers-color-scheme: dark)");
const isDark = () => (document.documentElement.dataset.theme || (system.matches ? "dark" : "light")) === "dark";
const themed = [];
function changed() { themed.forEach(f => f()); }
system.addEventListener("change", changed);
document.getElementById("theme").addEventListener("click", () => {
  document.documentElement.dataset.theme = isDark() ? "light" : "dark";
  changed();
});

function recoloured(spec) {
  if (!isDark() || printing) return structuredClone(spec);
  let text = JSON.stringify(spec);
  for (const [light, dark] of Object.entries(colours)) text = text.replaceAll(`"${light}"`, `"${dark}"`);
  return JSON.parse(text);
}

// --- plots ---------------------------------------------------------------------------------------------------------
const LINKED = ["force", "gap"];
const drawn = new Set();
let printing = false, library = null;
// The text of an element that holds base64 of gzip.
function unpacked(id) {
  const bytes = Uint8Array.from(atob(document.getElementById(id).textContent), c => c.charCodeAt(0));
  return new Response(new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"))).text();
}

function plotly() {
  library = library || unpacked("plotly-source").then(text => {
    const script = document.createElement("script");
    script.textContent = text;
    document.head.append(script);
    return window.Plotly;
  });
  return library;
}

async function plot(name) {
  const P = await plotly(), at = document.getElementById("plot-" + name), spec = recoloured(specs[name]);
  const clear = "rgba(0,0,0,0)", { color } = getComputedStyle(document.body);
  Object.assign(spec.layout, { paper_bgcolor: clear, plot_bgcolor: clear, modebar: { bgcolor: clear, color: spec.layout.xaxis?.tickcolor ?? color, activecolor: color } });
  if (at.clientWidth < 520) narrowed(spec, name);
  if (LINKED.includes(name)) Object.assign(spec.layout, { hovermode: false, dragmode: "zoom" });
  const range = drawn.has(name) && LINKED.includes(name) ? at.layout.xaxis.range : null;
  if (range) spec.layout.xaxis.range = range;
  if (printing) spec.layout.width = 690;
  await P.react(at, spec.data, spec.layout, { responsive: true, displaylogo: false, displayModeBar: "hover",
    modeBarButtonsToRemove: ["select2d", "lasso2d", "autoScale2d"] });
  if (drawn.has(name)) return;
  drawn.add(name);
  if (LINKED.includes(name)) link(name, at);
}

// A list that chooses which traces of a plot are shown, by their meta.
for (const list of document.querySelectorAll("select[data-chooses]")) list.addEventListener("change", () => {
  const name = list.dataset.chooses;
  for (const trace of specs[name].data) trace.visible = trace.meta === Number(list.value);
  specs[name].layout.yaxis.title.text = list.selectedOptions[0].dataset.title;
  plot(name);
});

// Small screens: less margin, one panel above the other where two stood side by side.
function narrowed(spec, name) {
  const l = spec.layout;
  l.margin = Object.assign({}, l.margin, { l: 54, r: 8 });
  l.font = Object.assign({}, l.font, { size: 11 });
  if (name === "precheck") {
    const marker = spec.data.at(-1).marker;
    Object.assign(marker, { size: 5, colorbar: Object.assign(marker.colorbar, { orientation: "h", y: -0.02, yanchor: "top", thickness: 10, len: 1 }) });
    marker.colorbar.title.side = "bottom";
    Object.assign(l, { height: 400, margin: { l: 8, r: 8, t: 8, b: 70 } });
  }
  if (name === "energy" && l.xaxis2) {
    l.height = 620; l.xaxis.domain = l.xaxis2.domain = [0, 1];
    l.yaxis.domain = [0, 0.42]; l.yaxis2.domain = [0.58, 1];
    Object.assign(l.yaxis2, { showticklabels: true });
    l.annotations.forEach((a, k) => Object.assign(a, { y: k === 0 ? 0.42 : 1 }));
  }
}

// One cursor and one range of time for all linked plots.
const wires = {};
let cursorTime = null;
function link(name, at) {
  const bar = document.createElement("div");
  bar.className = "cursor"; bar.hidden = true; at.append(bar);
  wires[name] = { at, bar };
  const follow = e => {
    const axis = at._fullLayout.xaxis, x = e.clientX - at.getBoundingClientRect().left - axis._offset;
    if (x >= 0 && x <= axis._length) cursor(axis.p2d(x));
  };
  at.addEventListener("pointermove", follow); at.addEventListener("pointerdown", follow);
  at.addEventListener("pointerleave", () => cursor(null));
  at.on("plotly_relayout", change => {
    const range = at.layout.xaxis.range;
    if (!Object.keys(change).some(k => k.startsWith("xaxis"))) return;
    for (const [other, w] of Object.entries(wires)) {
      const now = w.at.layout.xaxis.range;
      if (other !== name && (now[0] !== range[0] || now[1] !== range[1])) Plotly.relayout(w.at, { "xaxis.range": [...range] });
    }
    cursor(cursorTime);
  });
}

function cursor(time) {
  cursorTime = time;
  const words = [];
  for (const name of LINKED) {
    if (!wires[name]) continue;
    const { at, bar } = wires[name], l = at._fullLayout, x = time === null ? -1 : l.xaxis.l2p(time);
    bar.hidden = x < 0 || x > l.xaxis._length;
    if (bar.hidden) continue;
    Object.assign(bar.style, { left: l.xaxis._offset + x + "px", top: l._size.t + "px", height: l._size.h + "px" });
    words.push(...values(name, time));
  }
  const at = document.getElementById("readout");
  if (at) at.textContent = words.length ? `${time.toFixed(5)} s: ${words.join("; ")}` : at.dataset.hint;
}

function values(name, time) {
  const rows = new Map();
  for (const trace of specs[name].data) {
    const axis = specs[name].layout["yaxis" + trace.yaxis.slice(1)], title = axis.title.text;
    const k = nearest(trace.x, time), value = trace.customdata ? trace.customdata[k] : trace.y[k];
    if (value === null || value === undefined) continue;
    const [what, unit] = [title.slice(0, title.lastIndexOf(",")), title.slice(title.lastIndexOf(",") + 2)];
    const run = specs[name].data.length > 1 ? trace.name.replace(" model", " ") : "";
    const key = `${what} ${name}`;
    rows.set(key, [...(rows.get(key) || []), `${run}${Number(value.toPrecision(3))} ${unit}`]);
  }
  return [...rows].map(([key, found]) => `${key} ${found.join(", ")}`);
}

function nearest(x, value) {
  let low = 0, high = x.length - 1;
  while (high - low > 1) { const k = (low + high) >> 1; if (x[k] > value) high = k; else low = k; }
  return value - x[low] < x[high] - value ? low : high;
}

// --- what is drawn only when it is about to be seen -----------------------------------------------------------------
const pending = new Map();
const sight = new IntersectionObserver(entries => entries.forEach(e => {
  if (e.isIntersecting && pending.has(e.target)) start(e.target);
}), { rootMargin: "400px" });
function later(element, make) { pending.set(element, make); sight.observe(element); }
function start(element) {
  const make = pending.get(element);
  pending.delete(element); sight.unobserve(element);
  return make();
}
Object.keys(specs).forEach(name => later(document.getElementById("plot-" + name), () => plot(name)));
themed.push(() => drawn.forEach(name => plot(name)));
all("details").forEach(d => d.addEventListener("toggle", () => window.dispatchEvent(new Event("resize"))));

window.addEventListener("beforeprint", () => {
  printing = true; all("details").forEach(d => { d.dataset.was = d.open; d.open = true; });
  [...pending.keys()].forEach(start); drawn.forEach(name => plot(name));
});
window.addEventListener("afterprint", () => {
  printing = false; all("details").forEach(d => { d.open = d.dataset.was === "true"; });
  drawn.forEach(name => plot(name));
});

// --- tables ---------------------------------------------------------------------------------------------------------
function figure(text) {
  const plain = text.replace(/[\u202f\u00a0 ]/g, "").replace(/\u2212/g, "-").replace(/%$/, "");
  if (plain.startsWith("<")) return Number(plain.slice(1)) * 0.999;
  return plain === "" || plain === "\u2013" ? NaN : Number(plain);
}

function sortable(table) {
  const body = table.tBodies[0], heads = all("tr.cols th", table);
  heads.forEach((head, k) => {
    if (!head.textContent.trim()) return;
    const button = document.createElement("button");
    button.type = "button"; button.append(...head.childNodes); head.append(button);
    button.addEventListener("click", () => {
      const up = head.getAttribute("aria-sort") !== "ascending", rows = [...body.rows];
      const texts = rows.map(r => r.cells[k].textContent.trim()), numbers = texts.map(figure);
      const numeric = texts.every((t, i) => !Number.isNaN(numbers[i]) || t === "" || t === "\u2013");
      const order = rows.map((_, i) => i).sort((a, b) => {
        if (!numeric) return texts[a].localeCompare(texts[b], "en", { numeric: true }) * (up ? 1 : -1);
        if (Number.isNaN(numbers[a]) || Number.isNaN(numbers[b])) return Number.isNaN(numbers[a]) - Number.isNaN(numbers[b]);
        return (numbers[a] - numbers[b]) * (up ? 1 : -1);
      });
      heads.forEach(h => h.removeAttribute("aria-sort"));
      head.setAttribute("aria-sort", up ? "ascending" : "descending");
      body.append(...order.map(i => rows[i]));
    });
  });
}
all("table.sortable").forEach(sortable);

all("button[data-csv]").forEach(button => button.addEventListener("click", () => {
  const link = document.createElement("a"), text = read(button.dataset.csv);
  link.href = URL.createObjectURL(new Blob([text], { type: "text/csv" }));
  link.download = button.dataset.name; link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 1000);
}));

// --- 3-D ------------------------------------------------------------------------------------------------------------
let shape = null;
const views = {};
function scene() { return shape = shape || read("scene"); }
function viewer(host, options) {
  try {
    const view = new Viewer(host, scene(), options);
    themed.push(() => view.draw());
    buttons(host, view);
    return view;
  } catch (error) {
    host.classList.add("without");
    host.replaceChildren(Object.assign(document.createElement("p"), { className: "absent",
      textContent: "This browser shows no 3-D (WebGL 2): " + error.message + ". The pictures below show the model." }));
    return null;
  }
}

function buttons(host, view) {
  const box = document.getElementById(host.dataset.parts), make = (text, pressed, colour, act) => {
    const b = document.createElement("button");
    b.type = "button"; b.className = "chip"; b.setAttribute("aria-pressed", pressed); b.textContent = text;
    if (colour) { const dot = document.createElement("i"); dot.style.background = colour; b.prepend(dot); }
    b.addEventListener("click", () => { const on = b.getAttribute("aria-pressed") !== "true"; b.setAttribute("aria-pressed", on); act(on); view.draw(); });
    box.append(b);
  };
  const toggle = name => on => { if (on) view.hidden.delete(name); else view.hidden.add(name); };
  scene().parts.forEach(p => make(p.name, true, p.colour, toggle(p.name)));
  const marks = { contact: ["contact nodes", "#ffffff"], held: ["held", "#1b1f24"], driven: ["driven", "#009e73"],
    measured: ["measured points", "#d55e00"] };
  Object.keys(scene().marks).forEach(name => make(marks[name][0], true, marks[name][1], toggle("marks:" + name)));
  make("edges", true, "", on => { view.edges = on; });
  section(box, view);
  for (const [text, act] of [["front", () => view.front()], ["reset", () => view.reset()]]) {
    const b = document.createElement("button");
    b.type = "button"; b.className = "chip plain"; b.textContent = text; b.addEventListener("click", act); box.append(b);
  }
}

function short(value, digits) { return Number(value.toPrecision(digits)); }
function scale(kind, most, unit) { return `<p><i class="${kind}"></i><span>0</span><span>${most} ${unit}</span></p>`; }

// A section through the model: an axis, and how far along it.
function section(box, view) {
  const label = Object.assign(document.createElement("label"), { className: "chip", textContent: "section " });
  const axis = document.createElement("select"), far = Object.assign(document.createElement("input"),
    { type: "range", min: 0, max: 1, step: 0.005, value: 0.5, hidden: true });
  ["none", "x", "y", "z"].forEach(name => axis.append(new Option(name, name)));
  far.setAttribute("aria-label", "place of the section");
  const cut = () => {
    const k = ["x", "y", "z"].indexOf(axis.value);
    far.hidden = k < 0; view.cut = k < 0 ? null : [k, Number(far.value)];
    view.draw();
  };
  axis.addEventListener("change", cut); far.addEventListener("input", cut);
  label.append(axis, far); box.append(label);
}

const overview = document.getElementById("view-places");
if (overview) {
  const told = row => views.places && views.places.impulses.has(row) ? `, impulse ${short(views.places.impulses.get(row), 2)} ${overview.dataset.impulse}` : "";
  const begin = () => {
    views.places = viewer(overview, { label: "Model with the rattling places; arrow keys turn it, plus and minus zoom", told });
    if (!views.places || !scene().impulse) return;
    overview.append(Object.assign(document.createElement("div"), { className: "legend",
      innerHTML: "impulse of a contact node" + scale("pressed", short(scene().impulse.largest, 3), overview.dataset.impulse) }));
  };
  later(overview, () => requestAnimationFrame(() => setTimeout(begin, 0)));
  all("#places .card").forEach(row => {
    const number = Number(row.dataset.place), say = on => () => views.places && views.places.look(on ? number : null);
    row.addEventListener("pointerenter", say(true)); row.addEventListener("pointerleave", say(false));
  });
}

const stage = document.getElementById("view-motion");
if (stage) later(stage, () => setTimeout(player, 0));
function player() {
  const told = row => {
    const a = view.animation, u = Math.hypot(...view.moved(row)) / view.exaggeration;
    const k = Math.min(Math.round(view.frame), a.time.length - 1), j = a.nodes.indexOf(row);
    const force = j < 0 ? "" : `, ${short(a.few[k * a.nodes.length + j] / 255 * a.peak, 2)} ${stage.dataset.force}`;
    return a.mode ? `, ${short(100 * u / a.largest, 2)} % of the largest` : `, moved ${short(u, 3)} ${stage.dataset.length}${force}`;
  };
  const view = views.motion = viewer(stage, { label: "Motion of the model; arrow keys turn it, plus and minus zoom", told });
  if (!view) return;
  const legend = stage.appendChild(Object.assign(document.createElement("div"), { className: "legend" }));
  const tint = Object.assign(document.createElement("button"), { type: "button", className: "chip", textContent: "colour by displacement" });
  tint.setAttribute("aria-pressed", "false");
  tint.addEventListener("click", () => {
    view.tinted = !view.tinted; tint.setAttribute("aria-pressed", view.tinted); explain(); view.draw();
  });
  document.getElementById(stage.dataset.parts).append(tint);
  const explain = () => {
    const a = view.animation, moved = a.mode ? ["100", "% of the largest"] : [short(a.largest, 3), stage.dataset.length];
    legend.innerHTML = (view.tinted ? "displacement" + scale("moved", ...moved) : "")
      + (a.mode ? "" : "contact force" + scale("pressed", short(a.peak, 3), stage.dataset.force));
  };
  const motions = read("motions"), $ = id => document.getElementById(id);
  const play = $("play"), slider = $("frame"), counter = $("frame-counter"), much = $("exaggeration"), enlarged = $("exaggeration-told");
  let playing = false, last = 0;
  const size = view.radius;
  const show = () => {
    const a = view.animation, i = Math.floor(view.frame);
    slider.value = view.frame;
    const k = Math.min(Math.round(view.frame), a.time.length - 1), n = a.nodes.length;
    let force = 0;
    for (let j = 0; j < n; j++) force = Math.max(force, a.few[k * n + j]);
    counter.textContent = a.mode ? `${a.label}: one period, size at will`
      : `frame ${i + 1} of ${a.time.length}: ${a.time[i].toFixed(4)} s, hardest pressed node ${short(force / 255 * a.peak, 2)} ${stage.dataset.force}, raw`;
    if (wires.force && !a.mode) cursor(a.time[i]);
    view.draw();
  };
  const enlarge = () => {
    view.exaggeration = Math.pow(10, Number(much.value));
    enlarged.textContent = `${short(view.exaggeration, 2)} times`;
    view.draw();
  };
  const choose = k => {
    const a = motions[k];
    view.animate(a);
    slider.max = a.time.length - 1;
    much.value = Math.max(0, Math.min(Number(much.max), Math.log10(0.08 * size / a.largest)));
    view.frame = Math.max(0, a.time.findIndex(t => t >= a.touch));
    explain(); enlarge(); show();
  };
  const tick = now => {
    if (!playing) return;
    const a = view.animation, pace = Number($("pace").value);
    view.frame += Math.min(0.1, (now - last) / 1000) * pace;
    if (view.frame > a.time.length - 1) view.frame = 0;
    last = now; show(); requestAnimationFrame(tick);
  };
  const run = on => {
    playing = on; play.textContent = on ? "Pause" : "Play"; play.setAttribute("aria-pressed", on);
    if (on) { last = performance.now(); requestAnimationFrame(tick); }
  };
  play.addEventListener("click", () => run(!playing));
  slider.addEventListener("input", () => { run(false); view.frame = Number(slider.value); show(); });
  much.addEventListener("input", enlarge);
  $("motion-event").addEventListener("change", e => choose(Number(e.target.value)));
  new IntersectionObserver(e => { if (!e[0].isIntersecting && playing) run(false); }).observe(stage);
  stage.classList.add("ready");
  choose(0);
}
all("[data-animate]").forEach(b => b.addEventListener("click", () => {
  const pick = document.getElementById("motion-event");
  document.getElementById("motion").scrollIntoView();
  const go = () => { pick.value = b.dataset.animate; pick.dispatchEvent(new Event("change")); };
  if (pending.has(stage)) start(stage);
  setTimeout(go, 50);
}));
