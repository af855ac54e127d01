// Draws the textured cable with plain WebGL and lets a person turn it.
// Reads the record written by viewer.py from #viewer-data; the host element is #viewer.
(() => {
  "use strict";
  const host = document.getElementById("viewer");
  const canvas = host.querySelector("canvas");
  const labels = host.querySelector(".ring-labels");
  const gl = canvas.getContext("webgl", { antialias: true, preserveDrawingBuffer: true });
  if (!gl) { host.classList.add("no-webgl"); return; }

  const record = JSON.parse(document.getElementById("viewer-data").textContent);
  const bytes = (text) => Uint8Array.from(atob(text), (c) => c.charCodeAt(0)).buffer;
  const positions = new Float32Array(bytes(record.vertices));
  const indices = new Uint16Array(bytes(record.indices));

  // --- extent of the model: centre, half length along y, radius -----------------------------------------
  const low = [Infinity, Infinity, Infinity], high = [-Infinity, -Infinity, -Infinity];
  positions.forEach((v, i) => { low[i % 3] = Math.min(low[i % 3], v); high[i % 3] = Math.max(high[i % 3], v); });
  const centre = low.map((v, i) => (v + high[i]) / 2);
  const halfLength = (high[1] - low[1]) / 2;
  const radius = Math.max(high[0] - low[0], high[2] - low[2]) / 2;

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
    attribute vec3 position, normal; attribute vec2 uv;
    uniform mat4 clip; uniform mat3 turn; uniform vec3 centre; uniform float away;
    varying vec3 facing, sight; varying vec2 place;
    void main() {
      vec3 eye = turn * (position - centre) - vec3(0.0, 0.0, away);
      facing = turn * normal; sight = -eye; place = uv;
      gl_Position = clip * vec4(eye, 1.0);
    }`));
  gl.attachShader(program, compile(gl.FRAGMENT_SHADER, `
    precision mediump float;
    uniform sampler2D picture; uniform float textured; uniform vec4 paint;
    varying vec3 facing, sight; varying vec2 place;
    void main() {
      vec3 n = normalize(facing);
      float outside = step(0.0, dot(n, sight));
      float light = max(dot(n, normalize(vec3(0.3, 0.55, 0.78))), 0.0);
      vec3 shape = vec3(0.76, 0.79, 0.82) * (0.28 + 0.78 * light);
      vec3 skin = texture2D(picture, place).rgb * (0.72 + 0.38 * light);
      vec3 inside = vec3(0.36, 0.40, 0.44);
      vec3 surface = mix(inside, mix(shape, skin, textured), outside);
      gl_FragColor = vec4(mix(surface, paint.rgb, paint.a), 1.0);
    }`));
  gl.linkProgram(program);
  gl.useProgram(program);
  const uniform = (name) => gl.getUniformLocation(program, name);
  const at = Object.fromEntries(
    ["clip", "turn", "centre", "away", "textured", "paint"].map((name) => [name, uniform(name)]));

  // --- geometry: the model, and one narrow band per station ----------------------------------------------
  const buffer = (target, data) => {
    const made = gl.createBuffer();
    gl.bindBuffer(target, made);
    gl.bufferData(target, data, gl.STATIC_DRAW);
    return made;
  };
  const model = {
    position: buffer(gl.ARRAY_BUFFER, positions),
    normal: buffer(gl.ARRAY_BUFFER, new Int8Array(bytes(record.normals))),
    uv: buffer(gl.ARRAY_BUFFER, new Uint16Array(bytes(record.uv))),
    indices: buffer(gl.ELEMENT_ARRAY_BUFFER, indices),
  };
  const STEPS = 96, ringPoint = (ring, k, y, grow) => {
    const a = (2 * Math.PI * k) / STEPS;
    return [ring.centre[0] + grow * ring.radius * Math.cos(a), ring.centre[1] + y,
      ring.centre[2] - grow * ring.radius * Math.sin(a)];
  };
  const ringBuffers = record.stations.map((ring) => {
    const strip = [], half = 0.012 * ring.radius;
    for (let k = 0; k <= STEPS; k++)
      strip.push(...ringPoint(ring, k, -half, 1.012), ...ringPoint(ring, k, half, 1.012));
    return buffer(gl.ARRAY_BUFFER, new Float32Array(strip));
  });
  const tags = record.stations.map((ring) => {
    const tag = document.createElement("span"), name = document.createElement("b");
    const size = document.createElement("i");
    name.textContent = ring.name;
    size.textContent = ring.text;
    tag.append(name, size);
    labels.append(tag);
    return tag;
  });

  // --- the view: yaw turns the cable in the picture's plane, spin turns it about its own axis -------------
  const START = { yaw: -0.36, pitch: 0.2, spin: 0, zoom: 1, along: 0 };
  const view = { ...START, turning: !matchMedia("(prefers-reduced-motion: reduce)").matches, textured: true };
  const multiply = (A, B) => A.map((row) => B[0].map((_, j) => row.reduce((s, v, k) => s + v * B[k][j], 0)));
  const turnMatrix = () => {
    const [cy, sy] = [Math.cos(view.yaw), Math.sin(view.yaw)];
    const [cp, sp] = [Math.cos(view.pitch), Math.sin(view.pitch)];
    const [cs, ss] = [Math.cos(view.spin), Math.sin(view.spin)];
    // Cable y to the right, z up, x towards the viewer; then spin, yaw, pitch.
    const place = [[0, 1, 0], [0, 0, 1], [1, 0, 0]];
    const spin = [[1, 0, 0], [0, cs, -ss], [0, ss, cs]];
    const yaw = [[cy, 0, sy], [0, 1, 0], [-sy, 0, cy]];
    const pitch = [[1, 0, 0], [0, cp, -sp], [0, sp, cp]];
    return multiply(pitch, multiply(yaw, multiply(spin, place)));
  };

  const draw = () => {
    const width = canvas.clientWidth, height = canvas.clientHeight, dense = Math.min(devicePixelRatio || 1, 2);
    canvas.width = Math.round(width * dense);
    canvas.height = Math.round(height * dense);
    gl.viewport(0, 0, canvas.width, canvas.height);
    const aspect = width / height, focal = 1 / Math.tan(Math.PI / 12);
    const away = (Math.max((halfLength * focal) / aspect, radius * focal) * 1.12 + radius) / view.zoom;
    const near = Math.max(0.02 * radius, away - halfLength - 2 * radius), far = away + 3 * halfLength + 3 * radius;
    const clip = [focal / aspect, 0, 0, 0, 0, focal, 0, 0,
      0, 0, (far + near) / (near - far), -1, 0, 0, (2 * far * near) / (near - far), 0];
    const turn = turnMatrix(), middle = [centre[0], centre[1] + view.along, centre[2]];

    gl.clearColor(0, 0, 0, 0);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    gl.enable(gl.DEPTH_TEST);
    gl.uniformMatrix4fv(at.clip, false, clip);
    gl.uniformMatrix3fv(at.turn, false, turn[0].map((_, j) => turn.map((row) => row[j])).flat());
    gl.uniform3fv(at.centre, middle);
    gl.uniform1f(at.away, away);
    gl.uniform1f(at.textured, view.textured && host.dataset.ready ? 1 : 0);
    gl.uniform4f(at.paint, 0, 0, 0, 0);
    const attribute = (index, data, size, type, norm, stride) => {
      gl.bindBuffer(gl.ARRAY_BUFFER, data);
      gl.enableVertexAttribArray(index);
      gl.vertexAttribPointer(index, size, type, norm, stride, 0);
    };
    const slot = (name) => gl.getAttribLocation(program, name);
    attribute(slot("position"), model.position, 3, gl.FLOAT, false, 0);
    attribute(slot("normal"), model.normal, 3, gl.BYTE, true, 4);
    attribute(slot("uv"), model.uv, 2, gl.UNSIGNED_SHORT, true, 0);
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, model.indices);
    gl.drawElements(gl.TRIANGLES, indices.length, gl.UNSIGNED_SHORT, 0);

    gl.disableVertexAttribArray(slot("normal"));
    gl.disableVertexAttribArray(slot("uv"));
    gl.uniform4f(at.paint, 0.835, 0.369, 0, 1);
    for (const ring of ringBuffers) {
      attribute(slot("position"), ring, 3, gl.FLOAT, false, 0);
      gl.drawArrays(gl.TRIANGLE_STRIP, 0, 2 * (STEPS + 1));
    }
    placeLabels(turn, middle, away, focal, aspect, width, height);
  };

  // Each label stands above the highest visible point of its ring; one that would cover another is left out.
  const placeLabels = (turn, middle, away, focal, aspect, width, height) => {
    const taken = [];
    record.stations.forEach((ring, i) => {
      let top = null;
      for (let k = 0; k < STEPS; k += 2) {
        const p = ringPoint(ring, k, 0, 1.02).map((v, j) => v - middle[j]);
        const [x, y, z] = turn.map((row) => row[0] * p[0] + row[1] * p[1] + row[2] * p[2]);
        if (away - z < 0.01) continue;
        const px = (0.5 + (0.5 * focal * x) / aspect / (away - z)) * width;
        const py = (0.5 - (0.5 * focal * y) / (away - z)) * height;
        if (!top || py < top[1]) top = [px, py];
      }
      const tag = tags[i], half = tag.offsetWidth / 2 + 3;
      const shown = top && top[0] > half && top[0] < width - half && top[1] > 24 && top[1] < height &&
        taken.every(([x, w]) => Math.abs(x - top[0]) > half + w);
      tag.style.visibility = shown ? "visible" : "hidden";
      if (!shown) return;
      taken.push([top[0], half]);
      // In percent, so that they stay in place when the page is printed at another width.
      tag.style.left = `${(100 * top[0]) / width}%`;
      tag.style.top = `${(100 * (top[1] - 6)) / height}%`;
    });
  };

  // --- drawing on demand ---------------------------------------------------------------------------------
  let waiting = false, visible = true, last = 0;
  const tick = (now) => {
    waiting = false;
    if (view.turning) view.spin += Math.min(now - last, 50) * 0.00025;
    last = now;
    draw();
    if (view.turning && visible) request();
  };
  const request = () => { if (!waiting) { waiting = true; requestAnimationFrame(tick); } };
  new IntersectionObserver(([entry]) => { visible = entry.isIntersecting; request(); }).observe(canvas);
  new ResizeObserver(request).observe(canvas);

  // --- hands -----------------------------------------------------------------------------------------------
  const box = (name) => host.querySelector(`input[name=${name}]`);
  const setTurning = (on) => { view.turning = box("turn").checked = on; request(); };
  const zoomBy = (factor) => { view.zoom = Math.min(12, Math.max(0.6, view.zoom * factor)); request(); };
  box("turn").checked = view.turning;
  box("turn").onchange = (event) => setTurning(event.target.checked);
  box("texture").onchange = (event) => { view.textured = event.target.checked; request(); };
  const fingers = new Map();
  canvas.onpointerdown = (event) => {
    canvas.setPointerCapture(event.pointerId);
    fingers.set(event.pointerId, [event.clientX, event.clientY]);
    setTurning(false);
  };
  canvas.onpointermove = (event) => {
    const before = fingers.get(event.pointerId);
    if (!before) return;
    const now = [event.clientX, event.clientY], dx = now[0] - before[0], dy = now[1] - before[1];
    const other = [...fingers].find(([id]) => id !== event.pointerId);
    if (other) {
      const gap = (p) => Math.hypot(p[0] - other[1][0], p[1] - other[1][1]);
      zoomBy(gap(now) / Math.max(gap(before), 1));
      moveAlong(dx / 2);
    } else if (event.shiftKey) {
      moveAlong(dx);
    } else {
      view.yaw += dx * 0.006;
      view.spin += dy * 0.008;
    }
    fingers.set(event.pointerId, now);
    request();
  };
  const moveAlong = (pixels) => {
    const step = (2 * halfLength * pixels) / canvas.clientWidth / view.zoom * Math.sign(Math.cos(view.yaw) || 1);
    view.along = Math.min(halfLength, Math.max(-halfLength, view.along - step));
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
      ArrowLeft: () => (view.yaw -= 0.1), ArrowRight: () => (view.yaw += 0.1),
      ArrowUp: () => (view.spin -= 0.1), ArrowDown: () => (view.spin += 0.1),
      "+": () => zoomBy(1.15), "-": () => zoomBy(1 / 1.15),
    }[event.key];
    if (!act) return;
    event.preventDefault();
    setTurning(false);
    act();
    request();
  };

  // --- texture ---------------------------------------------------------------------------------------------
  const image = new Image();
  image.onload = () => {
    gl.bindTexture(gl.TEXTURE_2D, gl.createTexture());
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGB, gl.RGB, gl.UNSIGNED_BYTE, image);
    gl.generateMipmap(gl.TEXTURE_2D);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.LINEAR_MIPMAP_LINEAR);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_WRAP_S, gl.CLAMP_TO_EDGE);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_WRAP_T, gl.CLAMP_TO_EDGE);
    const sharp = gl.getExtension("EXT_texture_filter_anisotropic");
    if (sharp) gl.texParameteri(gl.TEXTURE_2D, sharp.TEXTURE_MAX_ANISOTROPY_EXT, 4);
    host.dataset.ready = "yes";
    request();
  };
  image.src = record.texture;
})();
