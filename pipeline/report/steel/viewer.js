// Draws the fitted steel structure with plain WebGL and lets a person turn it about the vertical.
// Reads the record written by viewer.py from #viewer-data; the host element is #viewer.
(() => {
  "use strict";
  const host = document.getElementById("viewer");
  const canvas = host.querySelector("canvas"), labels = host.querySelector(".ring-labels");
  const gl = canvas.getContext("webgl", { antialias: true, preserveDrawingBuffer: true });
  if (!gl) { host.classList.add("no-webgl"); return; }
  const record = JSON.parse(document.getElementById("viewer-data").textContent);

  // --- triangles: position (3), normal (3), colour (3) a vertex -------------------------------------------
  const sub = (a, b) => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
  const add = (a, b, s) => [a[0] + s * b[0], a[1] + s * b[1], a[2] + s * b[2]];
  const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
  const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
  const unit = (a) => { const n = Math.hypot(...a) || 1; return [a[0] / n, a[1] / n, a[2] / n]; };
  const paint = (hex) => [1, 3, 5].map((i) => parseInt(hex.slice(i, i + 2), 16) / 255);
  const many = record.rods.length + record.balls.length > 1500;

  const tube = (out, start, end, first, last, colour, sides) => {
    const axis = unit(sub(end, start));
    const u = unit(cross(axis, Math.abs(axis[2]) < 0.9 ? [0, 0, 1] : [1, 0, 0])), v = cross(axis, u);
    const ring = Array.from({ length: sides + 1 }, (_, k) => {
      const a = (2 * Math.PI * k) / sides;
      return add([Math.cos(a) * u[0], Math.cos(a) * u[1], Math.cos(a) * u[2]], v, Math.sin(a));
    });
    const push = (centre, radius, normal) => out.push(...add(centre, normal, radius), ...normal, ...colour);
    for (let k = 0; k < sides; k++) {
      const a = ring[k], b = ring[k + 1];
      push(start, first, a); push(start, first, b); push(end, last, b);
      push(start, first, a); push(end, last, b); push(end, last, a);
    }
    const back = axis.map((x) => -x);
    for (const [centre, radius, normal] of [[start, first, back], [end, last, axis]]) {
      if (!radius) continue;
      for (let k = 0; k < sides; k++) {
        out.push(...centre, ...normal, ...colour);
        for (const edge of [ring[k], ring[k + 1]]) out.push(...add(centre, edge, radius), ...normal, ...colour);
      }
    }
  };
  const ball = (out, centre, radius, colour, rows) => {
    const at = (i, j) => {
      const p = (Math.PI * i) / rows, a = (Math.PI * j) / rows;
      return [Math.sin(p) * Math.cos(a), Math.sin(p) * Math.sin(a), Math.cos(p)];
    };
    const push = (n) => out.push(...add(centre, n, radius), ...n, ...colour);
    for (let i = 0; i < rows; i++) for (let j = 0; j < 2 * rows; j++) {
      const [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
      if (i < rows - 1) { push(a); push(b); push(c); }
      if (i > 0) { push(a); push(c); push(d); }
    }
  };
  const ends = (t) => [t.slice(0, 3), t.slice(3, 6)];
  const build = {
    rods: (out, t) => tube(out, ...ends(t), t[6], t[6], paint(t[7]), many ? 6 : 12),
    columns: (out, t) => tube(out, ...ends(t), t[6], t[6], paint(t[7]), 20),
    arrows: (out, t) => {
      const [start, end] = ends(t), neck = add(end, sub(end, start), -0.3);
      tube(out, start, neck, t[6], t[6], paint(t[7]), 10);
      tube(out, neck, end, 2.4 * t[6], 0, paint(t[7]), 10);
    },
    balls: (out, b) => ball(out, b.slice(0, 3), b[3], paint(b[4]), many ? 6 : 10),
    stations: (out, b) => ball(out, b.slice(0, 3), b[3], paint(b[4]), 6),
  };
  const parts = {};
  const low = [Infinity, Infinity, Infinity], high = [-Infinity, -Infinity, -Infinity];
  for (const name of Object.keys(build)) {
    const out = [];
    for (const item of record[name]) build[name](out, item);
    const data = new Float32Array(out);
    for (let n = 0; n < data.length; n += 9) for (let k = 0; k < 3; k++) {
      low[k] = Math.min(low[k], data[n + k]);
      high[k] = Math.max(high[k], data[n + k]);
    }
    const buffer = gl.createBuffer();
    gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
    gl.bufferData(gl.ARRAY_BUFFER, data, gl.STATIC_DRAW);
    parts[name] = { buffer, count: data.length / 9 };
    const box = host.querySelector(`input[name=${name}]`);
    if (!data.length) box.parentElement.remove();
  }
  const centre = low.map((x, k) => (x + high[k]) / 2), reach = Math.hypot(...sub(high, low)) / 2;

  // --- shaders -------------------------------------------------------------------------------------------
  const compile = (kind, source) => {
    const shader = gl.createShader(kind);
    gl.shaderSource(shader, source);
    gl.compileShader(shader);
    if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS)) throw new Error(gl.getShaderInfoLog(shader));
    return shader;
  };
  const program = gl.createProgram();
  gl.attachShader(program, compile(gl.VERTEX_SHADER, `
    attribute vec3 position, normal, colour;
    uniform mat4 clip; uniform mat3 turn; uniform vec3 middle; uniform float away;
    varying vec3 facing, skin;
    void main() {
      vec3 eye = turn * (position - middle) - vec3(0.0, 0.0, away);
      facing = turn * normal; skin = colour;
      gl_Position = clip * vec4(eye, 1.0);
    }`));
  gl.attachShader(program, compile(gl.FRAGMENT_SHADER, `
    precision mediump float;
    varying vec3 facing, skin;
    void main() {
      float light = max(dot(normalize(facing), normalize(vec3(0.25, 0.6, 0.76))), 0.0);
      gl_FragColor = vec4(skin * (0.42 + 0.66 * light), 1.0);
    }`));
  gl.linkProgram(program);
  gl.useProgram(program);
  const at = Object.fromEntries(["clip", "turn", "middle", "away"].map((n) => [n, gl.getUniformLocation(program, n)]));
  const slots = ["position", "normal", "colour"].map((name) => gl.getAttribLocation(program, name));

  // --- the view: azimuth about the vertical, height over the horizon -------------------------------------
  const wide = high[1] - low[1] > high[0] - low[0] ? Math.PI / 2 : 0;
  const START = { azimuth: wide - 0.5, height: 0.42, zoom: 1, x: 0, y: 0, z: 0 };
  const view = { ...START };
  const rows = () => {
    const [ca, sa, ch, sh] = [Math.cos(view.azimuth), Math.sin(view.azimuth), Math.cos(view.height), Math.sin(view.height)];
    const right = [ca, sa, 0], back = [sa * ch, -ca * ch, sh], up = [-sa * sh, ca * sh, ch];
    return [right, up, back];
  };
  START.rows = rows();
  const FOCAL = 1 / Math.tan(Math.PI / 10);
  // As near as all corners of the structure's box allow at the start, names above it included.
  const corners = [0, 1, 2, 3, 4, 5, 6, 7].map((n) => low.map((x, k) => (n >> k & 1 ? high[k] : x) - centre[k]));
  const distance = (aspect) => Math.max(...corners.map((p) => {
    const [x, y, z] = START.rows.map((row) => dot(row, p));
    return z + FOCAL * Math.max(Math.abs(x) / aspect / 0.95, Math.abs(y) / 0.88);
  })) / view.zoom;
  const tags = record.names.map((entry) => {
    const tag = document.createElement("span"), name = document.createElement("b"), size = document.createElement("i");
    name.textContent = entry.name;
    size.textContent = entry.text;
    tag.append(name, size);
    labels.append(tag);
    return tag;
  });

  const draw = () => {
    const width = canvas.clientWidth, height = canvas.clientHeight, dense = Math.min(devicePixelRatio || 1, 2);
    canvas.width = Math.round(width * dense);
    canvas.height = Math.round(height * dense);
    gl.viewport(0, 0, canvas.width, canvas.height);
    const aspect = width / height, away = distance(aspect), turn = rows();
    const near = Math.max(0.005 * reach, away - 1.6 * reach), far = away + 2 * reach;
    const middle = [centre[0] + view.x, centre[1] + view.y, centre[2] + view.z];
    gl.clearColor(0, 0, 0, 0);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    gl.enable(gl.DEPTH_TEST);
    gl.uniformMatrix4fv(at.clip, false, [FOCAL / aspect, 0, 0, 0, 0, FOCAL, 0, 0,
      0, 0, (far + near) / (near - far), -1, 0, 0, (2 * far * near) / (near - far), 0]);
    gl.uniformMatrix3fv(at.turn, false, turn[0].map((_, j) => turn.map((row) => row[j])).flat());
    gl.uniform3fv(at.middle, middle);
    gl.uniform1f(at.away, away);
    for (const [name, part] of Object.entries(parts)) {
      if (!part.count || !shown(name)) continue;
      gl.bindBuffer(gl.ARRAY_BUFFER, part.buffer);
      slots.forEach((slot, k) => {
        gl.enableVertexAttribArray(slot);
        gl.vertexAttribPointer(slot, 3, gl.FLOAT, false, 36, 12 * k);
      });
      gl.drawArrays(gl.TRIANGLES, 0, part.count);
    }
    placeNames(turn, middle, away, aspect, width, height);
  };

  // A name that would cover another one is left out.
  const placeNames = (turn, middle, away, aspect, width, height) => {
    const taken = [];
    record.names.forEach((entry, n) => {
      const p = sub(entry.place, middle), [x, y, z] = turn.map((row) => dot(row, p));
      const px = (0.5 + (0.5 * FOCAL * x) / aspect / (away - z)) * width;
      const py = (0.5 - (0.5 * FOCAL * y) / (away - z)) * height;
      const tag = tags[n], half = tag.offsetWidth / 2 + 3;
      const fits = shown("names") && away - z > 0 && px > half && px < width - half && py > 26 && py < height &&
        taken.every(([a, b, w]) => Math.abs(a - px) > half + w || Math.abs(b - py) > 24);
      tag.style.visibility = fits ? "visible" : "hidden";
      if (!fits) return;
      taken.push([px, py, half]);
      tag.style.left = `${(100 * px) / width}%`;
      tag.style.top = `${(100 * (py - 6)) / height}%`;
    });
  };

  // --- drawing on demand, hands ---------------------------------------------------------------------------
  let waiting = false;
  const request = () => {
    if (waiting) return;
    waiting = true;
    requestAnimationFrame(() => { waiting = false; draw(); });
  };
  const shown = (name) => { const box = host.querySelector(`input[name=${name}]`); return !box || box.checked; };
  for (const box of host.querySelectorAll("input")) box.onchange = request;
  new ResizeObserver(request).observe(canvas);
  const zoomBy = (factor) => { view.zoom = Math.min(60, Math.max(0.4, view.zoom * factor)); request(); };
  const turnBy = (dx, dy) => {
    view.azimuth -= dx;
    view.height = Math.min(1.57, Math.max(-1.57, view.height + dy));
    request();
  };
  const moveBy = (dx, dy) => {
    const aspect = canvas.clientWidth / canvas.clientHeight, [right, up] = rows();
    const step = (2 * distance(aspect)) / FOCAL / canvas.clientHeight;
    [view.x, view.y, view.z] = add(add([view.x, view.y, view.z], right, -dx * step), up, dy * step);
    request();
  };
  const fingers = new Map();
  canvas.onpointerdown = (event) => {
    canvas.setPointerCapture(event.pointerId);
    fingers.set(event.pointerId, [event.clientX, event.clientY]);
  };
  canvas.onpointermove = (event) => {
    const before = fingers.get(event.pointerId);
    if (!before) return;
    const now = [event.clientX, event.clientY], dx = now[0] - before[0], dy = now[1] - before[1];
    const other = [...fingers].find(([id]) => id !== event.pointerId);
    if (other) {
      const gap = (p) => Math.hypot(p[0] - other[1][0], p[1] - other[1][1]);
      zoomBy(gap(now) / Math.max(gap(before), 1));
      moveBy(dx / 2, dy / 2);
    } else if (event.shiftKey || event.buttons & 6) moveBy(dx, dy);
    else turnBy(dx * 0.007, dy * 0.007);
    fingers.set(event.pointerId, now);
  };
  canvas.onpointerup = canvas.onpointercancel = (event) => fingers.delete(event.pointerId);
  canvas.ondblclick = () => { Object.assign(view, START); request(); };
  // The wheel scrolls the page until the view has been clicked: nobody likes to be caught while reading.
  canvas.addEventListener("wheel", (event) => {
    if (document.activeElement !== canvas) return;
    event.preventDefault();
    zoomBy(Math.exp(-event.deltaY * 0.0015));
  }, { passive: false });
  canvas.onkeydown = (event) => {
    const act = {
      ArrowLeft: () => turnBy(-0.1, 0), ArrowRight: () => turnBy(0.1, 0),
      ArrowUp: () => turnBy(0, 0.08), ArrowDown: () => turnBy(0, -0.08),
      "+": () => zoomBy(1.15), "-": () => zoomBy(1 / 1.15),
    }[event.key];
    if (!act) return;
    event.preventDefault();
    act();
  };
})();
