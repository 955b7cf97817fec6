// 3-D view of the model: shaded parts, edges, marks and motion, by WebGL 2; places are labels on top.
"use strict";
function bytesOf(text) {
  const raw = atob(text), out = new Uint8Array(raw.length);
  for (let i = 0; i < raw.length; i++) out[i] = raw.charCodeAt(i);
  return out.buffer;
}

// Displacements of all frames as 16-bit shares of the largest one, from shapes and their amplitudes.
function motionOf(a) {
  const shapes = new Int16Array(bytesOf(a.shapes)), rank = a.amplitudes[0].length, n = shapes.length / rank;
  const out = new Int16Array(a.amplitudes.length * n), sum = new Float32Array(n);
  a.amplitudes.forEach((row, k) => {
    sum.fill(0);
    row.forEach((value, j) => {
      const f = value * 32767 / a.largest, from = j * n;
      for (let i = 0; i < n; i++) sum[i] += f * shapes[from + i];
    });
    for (let i = 0; i < n; i++) out[k * n + i] = Math.max(-32767, Math.min(32767, Math.round(sum[i])));
  });
  return out;
}

function rgb(hex) { return [1, 3, 5].map(k => parseInt(hex.slice(k, k + 2), 16) / 255); }

class Viewer {
  // host: element that gets the canvas; scene: as creak.report.figures.scene makes it.
  constructor(host, scene, options = {}) {
    this.host = host; this.scene = scene; this.hidden = new Set(); this.animation = null;
    this.frame = 0; this.exaggeration = 1; this.edges = true; this.onframe = options.onframe || (() => {});
    this.tinted = false; this.cut = null; this.told = options.told || (() => "");
    this.canvas = document.createElement("canvas");
    this.canvas.tabIndex = 0; this.canvas.setAttribute("role", "img");
    this.canvas.setAttribute("aria-label", options.label || "Model in 3-D; arrow keys turn it, plus and minus zoom");
    this.overlay = document.createElementNS("http://www.w3.org/2000/svg", "svg");
    this.overlay.setAttribute("class", "overlay"); this.overlay.setAttribute("aria-hidden", "true");
    this.tip = Object.assign(document.createElement("div"), { className: "tip", hidden: true });
    host.replaceChildren(this.canvas, this.overlay, this.tip);
    this.gl = this.canvas.getContext("webgl2", { antialias: true, alpha: true, preserveDrawingBuffer: true });
    if (!this.gl) throw new Error("no WebGL 2");
    this.load(); this.reset(); this.labels(); this.listen();
    new ResizeObserver(() => this.draw()).observe(host);
  }

  load() {
    const gl = this.gl, s = this.scene;
    this.points = new Int16Array(bytesOf(s.points));
    this.faces = this.program(FACES, SHADE); this.dots = this.program(DOTS, ROUND);
    this.pointBuffer = this.buffer(gl.ARRAY_BUFFER, this.points);
    this.triangleBuffer = this.buffer(gl.ELEMENT_ARRAY_BUFFER, new Uint32Array(bytesOf(s.triangles)));
    this.edgeBuffer = this.buffer(gl.ELEMENT_ARRAY_BUFFER, new Uint32Array(bytesOf(s.edges)));
    this.motionBuffer = gl.createBuffer(); this.heatBuffer = gl.createBuffer();
    this.markBuffers = Object.fromEntries(Object.entries(s.marks).map(
      ([name, rows]) => [name, [this.buffer(gl.ELEMENT_ARRAY_BUFFER, new Uint32Array(rows)), rows.length]]));
    let far = 0;
    for (let i = 0; i < this.points.length; i += 3)
      far = Math.max(far, Math.hypot(this.points[i], this.points[i + 1], this.points[i + 2]));
    this.radius = far * s.scale;
    this.low = [0, 1, 2].map(k => this.extreme(k, Math.min)); this.high = [0, 1, 2].map(k => this.extreme(k, Math.max));
    this.ids = new Int32Array(bytesOf(s.ids));
    this.impulses = new Map();
    if (!s.impulse) return;
    const shares = new Uint8Array(bytesOf(s.impulse.shares)), every = new Uint8Array(s.count);
    s.impulse.nodes.forEach((row, j) => { every[row] = shares[j]; this.impulses.set(row, s.impulse.values[j]); });
    this.impulseBuffer = this.buffer(gl.ARRAY_BUFFER, every);
  }

  extreme(k, better) {
    let found = this.points[k];
    for (let i = k; i < this.points.length; i += 3) found = better(found, this.points[i]);
    return found * this.scene.scale;
  }

  // Plane of the section: what lies beyond it along an axis of the model is not drawn.
  plane() {
    if (!this.cut) return [0, 0, 0, 1];
    const [k, share] = this.cut, normal = [0, 0, 0];
    normal[k] = 1;
    return [...normal, this.low[k] + share * (this.high[k] - this.low[k])];
  }

  // Row of the part of each node, the first one that has it.
  partOf() {
    if (this.owner) return this.owner;
    this.owner = new Int16Array(this.scene.count).fill(-1);
    const corners = new Uint32Array(bytesOf(this.scene.triangles)), ends = new Uint32Array(bytesOf(this.scene.edges));
    this.scene.parts.forEach((p, k) => {
      const mine = row => { if (this.owner[row] < 0) this.owner[row] = k; };
      corners.subarray(3 * p.triangles[0], 3 * (p.triangles[0] + p.triangles[1])).forEach(mine);
      ends.subarray(2 * p.edges[0], 2 * (p.edges[0] + p.edges[1])).forEach(mine);
    });
    return this.owner;
  }

  // Row of the drawn node nearest to the reader within some pixels of a point of the screen; -1: none is there.
  pick(x, y, within = 9) {
    const T = this.turn(), { w, h, unit } = this.size(), c = this.target(), s = this.scene.scale, owner = this.partOf();
    const plane = this.plane(), hidden = this.scene.parts.map(p => this.hidden.has(p.name));
    let best = -1, nearest = -Infinity;
    for (let row = 0; row < this.scene.count; row++) {
      if (owner[row] < 0 || hidden[owner[row]]) continue;
      const u = this.moved(row), at = [0, 1, 2].map(k => this.points[3 * row + k] * s + u[k]);
      if (plane[0] * at[0] + plane[1] * at[1] + plane[2] * at[2] > plane[3]) continue;
      const d = at.map((v, k) => v - c[k]), seen = k => T[k][0] * d[0] + T[k][1] * d[1] + T[k][2] * d[2];
      if (Math.abs(w / 2 + seen(0) / unit / 2 - x) > within || Math.abs(h / 2 - seen(1) / unit / 2 - y) > within) continue;
      if (seen(2) > nearest) { nearest = seen(2); best = row; }
    }
    return best;
  }

  // Node and part under the pointer, and what the page says of them.
  point(e) {
    if (this.pointing) return;
    this.pointing = true;
    requestAnimationFrame(() => {
      this.pointing = false;
      const box = this.host.getBoundingClientRect(), x = e.clientX - box.left, y = e.clientY - box.top;
      const row = this.pick(x, y);
      this.tip.hidden = row < 0;
      if (row < 0) return;
      this.tip.textContent = `node ${this.ids[row]} of ${this.scene.parts[this.owner[row]].name}${this.told(row)}`;
      Object.assign(this.tip.style, { left: Math.min(x + 14, box.width - 190) + "px", top: Math.max(y - 30, 2) + "px" });
    });
  }

  buffer(target, data) {
    const b = this.gl.createBuffer();
    this.gl.bindBuffer(target, b); this.gl.bufferData(target, data, this.gl.STATIC_DRAW);
    return b;
  }

  program(vertex, fragment) {
    const gl = this.gl, p = gl.createProgram();
    for (const [kind, text] of [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]]) {
      const shader = gl.createShader(kind);
      gl.shaderSource(shader, text); gl.compileShader(shader);
      if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS)) throw new Error(gl.getShaderInfoLog(shader));
      gl.attachShader(p, shader);
    }
    gl.linkProgram(p);
    const at = name => gl.getUniformLocation(p, name);
    return { p, at: Object.fromEntries(["turn", "frame", "size", "motion", "nearer", "dotsize", "colour", "lit", "rim", "cut", "tinted"]
      .map(n => [n, at(n)])) };
  }

  reset() { this.azimuth = -32; this.elevation = 18; this.zoom = 1; this.shift = [0, 0]; this.fit(); this.draw(); }
  front() { this.azimuth = 0; this.elevation = 0; this.zoom = 1; this.shift = [0, 0]; this.fit(); this.draw(); }

  // Rows of the matrix: right, up, toward the reader.
  turn() {
    const [right, up, toward] = this.scene.view, a = this.azimuth * Math.PI / 180, e = this.elevation * Math.PI / 180;
    const t = [0, 1, 2].map(k => Math.cos(e) * (Math.cos(a) * toward[k] + Math.sin(a) * right[k]) + Math.sin(e) * up[k]);
    const r = [0, 1, 2].map(k => Math.cos(a) * right[k] - Math.sin(a) * toward[k]);
    const u = [t[1] * r[2] - t[2] * r[1], t[2] * r[0] - t[0] * r[2], t[0] * r[1] - t[1] * r[0]];
    return [r, u, t];
  }

  // Half widths of the model as it is seen, and its middle.
  fit() {
    const [r, u] = this.turn(), p = this.points, low = [1e9, 1e9], high = [-1e9, -1e9];
    for (let i = 0; i < p.length; i += 3)
      [r, u].forEach((axis, k) => {
        const v = axis[0] * p[i] + axis[1] * p[i + 1] + axis[2] * p[i + 2];
        low[k] = Math.min(low[k], v); high[k] = Math.max(high[k], v);
      });
    const s = this.scene.scale;
    this.half = [0, 1].map(k => Math.max((high[k] - low[k]) / 2, 1) * s * 1.12);
    this.middle = [0, 1].map(k => (high[k] + low[k]) / 2 * s);
  }

  size() {
    const w = this.host.clientWidth || 1, h = this.host.clientHeight || 1;
    const unit = Math.max(this.half[0] / w, this.half[1] / h) / this.zoom;
    return { w, h, unit, half: [unit * w, unit * h] };
  }

  // Point of the screen, px, where node `row` is now.
  project(row) {
    const T = this.turn(), { w, h, unit } = this.size(), c = this.target(), s = this.scene.scale;
    const u = this.moved(row), x = [0, 1, 2].map(k => this.points[3 * row + k] * s + u[k] - c[k]);
    const [px, py] = [0, 1].map(k => (T[k][0] * x[0] + T[k][1] * x[1] + T[k][2] * x[2]) / unit / 2);
    return [w / 2 + px, h / 2 - py];
  }

  target() {
    const T = this.turn();
    return [0, 1, 2].map(k => T[0][k] * (this.middle[0] + this.shift[0]) + T[1][k] * (this.middle[1] + this.shift[1]));
  }

  moved(row) {
    const a = this.animation;
    if (!a) return [0, 0, 0];
    const i = Math.min(Math.floor(this.frame), a.time.length - 1), j = Math.min(i + 1, a.time.length - 1);
    const m = this.frame - i, n = 3 * this.scene.count, f = this.exaggeration * a.largest / 32767;
    return [0, 1, 2].map(k => f * ((1 - m) * a.data[i * n + 3 * row + k] + m * a.data[j * n + 3 * row + k]));
  }

  // Show the motion of an event; null: the model at rest.
  animate(animation) {
    const gl = this.gl;
    if (this.animation) this.animation.data = null;
    this.animation = animation; this.frame = 0;
    if (animation) {
      animation.data = motionOf(animation);
      gl.bindBuffer(gl.ARRAY_BUFFER, this.motionBuffer);
      gl.bufferData(gl.ARRAY_BUFFER, animation.data, gl.STATIC_DRAW);
      this.heat(animation);
    }
    this.draw();
  }

  heat(a) {
    const few = new Uint8Array(bytesOf(a.force)), n = a.nodes.length, all = new Uint8Array(this.scene.count * a.time.length);
    for (let k = 0; k < a.time.length; k++) a.nodes.forEach((row, j) => { all[k * this.scene.count + row] = few[k * n + j]; });
    a.few = few;
    this.gl.bindBuffer(this.gl.ARRAY_BUFFER, this.heatBuffer);
    this.gl.bufferData(this.gl.ARRAY_BUFFER, all, this.gl.STATIC_DRAW);
  }

  draw() {
    if (!this.half || this.waiting) return;
    this.waiting = true;
    requestAnimationFrame(() => { this.waiting = false; this.paint(); });
  }

  paint() {
    const gl = this.gl, { w, h, half } = this.size(), ratio = Math.min(window.devicePixelRatio || 1, 2);
    if (this.canvas.width !== Math.round(w * ratio) || this.canvas.height !== Math.round(h * ratio)) {
      this.canvas.width = Math.round(w * ratio); this.canvas.height = Math.round(h * ratio);
    }
    const style = getComputedStyle(this.host), ink = rgb(style.getPropertyValue("--ink").trim());
    gl.viewport(0, 0, this.canvas.width, this.canvas.height);
    gl.clearColor(0, 0, 0, 0); gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    gl.enable(gl.DEPTH_TEST); gl.enable(gl.BLEND);
    gl.blendFuncSeparate(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA, gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
    this.use(this.faces, half);
    this.paintFaces(ink);
    this.use(this.dots, half);
    this.paintDots(ratio);
    this.place(w, h);
  }

  use(program, half) {
    const gl = this.gl, at = program.at, a = this.animation, T = this.turn(), c = this.target();
    gl.useProgram(program.p);
    gl.uniformMatrix3fv(at.turn, true, T.flat());
    gl.uniform4f(at.frame, ...c, this.scene.scale);
    gl.uniform2f(at.size, half[0], half[1]);
    gl.uniform4f(at.cut, ...this.plane());
    gl.uniform1f(at.tinted, 0);
    gl.uniform3f(at.motion, a ? this.exaggeration * a.largest / 32767 : 0, this.frame - Math.floor(this.frame),
      0.25 / (this.radius || 1));
    gl.bindBuffer(gl.ARRAY_BUFFER, this.pointBuffer);
    gl.enableVertexAttribArray(0); gl.vertexAttribPointer(0, 3, gl.SHORT, false, 6, 0);
    const n = this.scene.count, i = Math.min(Math.floor(this.frame), a ? a.time.length - 1 : 0);
    const j = Math.min(i + 1, a ? a.time.length - 1 : 0);
    this.attribute(1, this.motionBuffer, 3, gl.SHORT, 6 * n * i, a, false);
    this.attribute(2, this.motionBuffer, 3, gl.SHORT, 6 * n * j, a, false);
    this.rows = [n * i, n * j];
    this.heated(false);
  }

  // Dots grow and redden with the contact force; at rest, with the impulse of the window.
  heated(on) {
    const moving = Boolean(this.animation), buffer = moving ? this.heatBuffer : this.impulseBuffer;
    [3, 4].forEach((at, k) => this.attribute(at, buffer, 1, this.gl.UNSIGNED_BYTE, moving ? this.rows[k] : 0, on && buffer, true));
  }

  attribute(at, buffer, count, type, offset, on, share) {
    const gl = this.gl;
    if (!on) { gl.disableVertexAttribArray(at); gl.vertexAttrib3f(at, 0, 0, 0); return; }
    gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
    gl.enableVertexAttribArray(at); gl.vertexAttribPointer(at, count, type, share, 0, offset);
  }

  paintFaces(ink) {
    const gl = this.gl, at = this.faces.at, seen = this.scene.parts.filter(p => !this.hidden.has(p.name));
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, this.triangleBuffer);
    gl.uniform1f(at.lit, 1); gl.uniform1f(at.nearer, 0); gl.uniform1f(at.dotsize, 1);
    gl.uniform1f(at.tinted, this.tinted && this.animation ? 1 : 0);
    for (const p of seen) {
      gl.uniform4f(at.colour, ...rgb(p.colour), 1);
      if (p.triangles[1]) gl.drawElements(gl.TRIANGLES, 3 * p.triangles[1], gl.UNSIGNED_INT, 12 * p.triangles[0]);
    }
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, this.edgeBuffer);
    gl.uniform1f(at.lit, 0); gl.uniform1f(at.nearer, 0.0006); gl.uniform1f(at.tinted, 0);
    for (const p of seen) {
      const loose = p.triangles[1] === 0;
      gl.uniform4f(at.colour, ...(loose ? ink : [0.08, 0.1, 0.13]), loose ? 0.8 : 0.3);
      if (p.edges[1] && (this.edges || loose)) gl.drawElements(gl.LINES, 2 * p.edges[1], gl.UNSIGNED_INT, 8 * p.edges[0]);
    }
  }

  paintDots(ratio) {
    const gl = this.gl, at = this.dots.at, looks = {
      held: [[0.1, 0.12, 0.14], 8], driven: [[0, 0.62, 0.45], 11], contact: [[1, 1, 1], 5.5], measured: [[0.84, 0.37, 0], 10] };
    gl.disable(gl.DEPTH_TEST); gl.uniform1f(at.nearer, 0);
    for (const [name, [colour, size]] of Object.entries(looks)) {
      if (!this.markBuffers[name] || this.hidden.has("marks:" + name)) continue;
      this.heated(name === "contact");
      const [buffer, count] = this.markBuffers[name];
      gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, buffer);
      gl.uniform4f(at.colour, ...colour, 1); gl.uniform4f(at.rim, ...(name === "contact" ? [0.3, 0.33, 0.37] : [1, 1, 1]), 1);
      gl.uniform1f(at.dotsize, size * ratio);
      gl.drawElements(gl.POINTS, count, gl.UNSIGNED_INT, 0);
    }
  }

  labels() {
    const make = (tag, parent, attributes) => {
      const e = document.createElementNS("http://www.w3.org/2000/svg", tag);
      for (const [k, v] of Object.entries(attributes)) e.setAttribute(k, v);
      return parent.appendChild(e);
    };
    this.signs = this.scene.places.slice(0, 12).map(p => {
      const g = make("g", this.overlay, { class: "place", "data-place": p.number });
      make("line", g, {}); make("circle", g, { r: 11 });
      make("text", g, { "text-anchor": "middle", dy: "0.36em" }).textContent = p.number;
      return [p, g];
    });
    this.axes = ["x", "y", "z"].map(name => {
      const g = make("g", this.overlay, { class: "axis" });
      const line = make("line", g, {}), text = make("text", g, { "text-anchor": "middle", dy: "0.35em" });
      text.textContent = name;
      return [line, text];
    });
  }

  // Signs stand above their nodes, on a line; those that would cover another one stand higher.
  place(w, h) {
    const taken = [];
    this.overlay.setAttribute("viewBox", `0 0 ${w} ${h}`);
    for (const [p, g] of this.signs) {
      const [x, foot] = this.project(p.at), line = g.firstChild;
      let y = foot - 30;
      for (let k = 0; k < 12 && taken.some(t => Math.hypot(t[0] - x, t[1] - y) < 24); k++) y -= 12;
      taken.push([x, y]);
      g.setAttribute("transform", `translate(${x.toFixed(1)} ${y.toFixed(1)})`);
      line.setAttribute("y1", 11); line.setAttribute("y2", (foot - y).toFixed(1));
      g.classList.toggle("hot", this.hot === p.number);
    }
    const T = this.turn();
    this.axes.forEach(([line, text], k) => {
      const dx = T[0][k], dy = -T[1][k];
      for (const [name, value] of [["x1", 34], ["y1", h - 34], ["x2", 34 + 20 * dx], ["y2", h - 34 + 20 * dy]])
        line.setAttribute(name, value);
      text.style.opacity = Math.hypot(dx, dy) < 0.25 ? 0 : 1;
      text.setAttribute("x", 34 + 28 * dx); text.setAttribute("y", h - 34 + 28 * dy);
    });
  }

  look(number) {
    this.hot = number;
    this.draw();
  }

  listen() {
    const at = new Map(), c = this.canvas;
    let spread = 0;
    c.addEventListener("pointerdown", e => { at.set(e.pointerId, [e.clientX, e.clientY]); c.setPointerCapture(e.pointerId); c.focus({ preventScroll: true }); spread = 0; });
    const end = e => { at.delete(e.pointerId); spread = 0; };
    ["pointerup", "pointercancel", "lostpointercapture"].forEach(n => c.addEventListener(n, end));
    c.addEventListener("pointermove", e => {
      const old = at.get(e.pointerId);
      if (!old) { this.point(e); return; }
      this.tip.hidden = true;
      const dx = e.clientX - old[0], dy = e.clientY - old[1];
      at.set(e.pointerId, [e.clientX, e.clientY]);
      if (at.size === 2) {
        const [a, b] = [...at.values()], now = Math.hypot(a[0] - b[0], a[1] - b[1]);
        if (spread) this.zoomBy(now / spread);
        spread = now; this.pan(dx / 2, dy / 2);
      } else if (e.shiftKey || e.buttons === 2 || e.buttons === 4) this.pan(dx, dy);
      else this.orbit(-0.4 * dx, 0.4 * dy);
    });
    c.addEventListener("pointerleave", () => { this.tip.hidden = true; });
    c.addEventListener("contextmenu", e => e.preventDefault());
    c.addEventListener("wheel", e => {
      if (document.activeElement !== c && !e.ctrlKey) return;
      e.preventDefault(); this.zoomBy(Math.exp(-0.0015 * e.deltaY));
    }, { passive: false });
    c.addEventListener("dblclick", () => this.reset());
    c.addEventListener("keydown", e => {
      const steps = { ArrowLeft: [6, 0], ArrowRight: [-6, 0], ArrowUp: [0, 6], ArrowDown: [0, -6] };
      if (steps[e.key]) this.orbit(...steps[e.key]);
      else if (e.key === "+" || e.key === "=") this.zoomBy(1.2);
      else if (e.key === "-") this.zoomBy(1 / 1.2);
      else if (e.key === "Home" || e.key === "0") this.reset();
      else return;
      e.preventDefault();
    });
  }

  orbit(a, e) {
    this.azimuth = (this.azimuth + a) % 360;
    this.elevation = Math.max(-89, Math.min(89, this.elevation + e));
    this.draw();
  }
  pan(dx, dy) {
    const { unit } = this.size();
    this.shift = [this.shift[0] - 2 * unit * dx, this.shift[1] + 2 * unit * dy];
    this.draw();
  }
  zoomBy(factor) { this.zoom = Math.max(0.3, Math.min(60, this.zoom * factor)); this.draw(); }
}
