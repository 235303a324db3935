// SPDX-License-Identifier: Apache-2.0
"use strict";
/**
 * Triangles and lines in 3D on canvases that share one camera, for the HTML report and the page of web/. Coordinates are
 * relative to the center of the scene, in units of its diameter. Canvases turn by dragging and by the arrow keys, and
 * zoom by the wheel and by + and -.
 */
const make_views = (canvases) => {
  const camera = { turn: -0.7, tilt: 0.45, distance: 1.25 };
  const kTriangles = [`#version 300 es
    in vec4 corner; uniform mat4 view; out vec3 at; out float quality; out vec3 edge;
    void main() {
      gl_Position = view * vec4(corner.xyz, 1.0); at = corner.xyz; quality = corner.w;
      edge = vec3(equal(ivec3(gl_VertexID % 3), ivec3(0, 1, 2)));
    }`, `#version 300 es
    precision highp float; in vec3 at; in float quality; in vec3 edge; out vec4 color;
    void main() {
      vec3 n = normalize(cross(dFdx(at), dFdy(at)));
      float light = 0.65 + 0.35 * abs(dot(n, normalize(vec3(0.4, -0.6, 0.7))));
      float q = clamp(quality, 0.0, 1.0);
      vec3 c = q < 0.5 ? mix(vec3(0.27, 0.0, 0.33), vec3(0.13, 0.57, 0.55), 2.0 * q) : mix(vec3(0.13, 0.57, 0.55), vec3(0.99, 0.91, 0.14), 2.0 * q - 1.0);
      if (quality < -0.5) c = vec3(0.85, 0.1, 0.1);
      vec3 d = edge / fwidth(edge);
      vec3 w = fwidth(edge);
      float line = 0.45 * (1.0 - smoothstep(0.08, 0.35, max(w.x, max(w.y, w.z)))); // none on faces of a few pixels
      color = vec4(c * light * mix(1.0 - line, 1.0, smoothstep(0.3, 1.2, min(d.x, min(d.y, d.z)))), 1.0);
    }`];
  const kLines = [`#version 300 es
    in vec3 end; uniform mat4 view; void main() { gl_Position = view * vec4(end, 1.0); }`, `#version 300 es
    precision highp float; out vec4 color; void main() { color = vec4(0.5, 0.5, 0.5, 1.0); }`];
  const compiled = (gl, texts, attribute, size) => {
    const program = gl.createProgram();
    [gl.VERTEX_SHADER, gl.FRAGMENT_SHADER].forEach((kind, i) => {
      const shader = gl.createShader(kind);
      gl.shaderSource(shader, texts[i]);
      gl.compileShader(shader);
      gl.attachShader(program, shader);
    });
    gl.linkProgram(program);
    const array = gl.createVertexArray(), buffer = gl.createBuffer(), location = gl.getAttribLocation(program, attribute);
    gl.bindVertexArray(array);
    gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
    gl.enableVertexAttribArray(location);
    gl.vertexAttribPointer(location, size, gl.FLOAT, false, 0, 0);
    return { program, array, buffer, size, view: gl.getUniformLocation(program, "view"), count: 0 };
  };
  const views = canvases.map((canvas) => {
    const gl = canvas.getContext("webgl2", { antialias: true, preserveDrawingBuffer: true });
    if (!gl) return null;
    gl.enable(gl.DEPTH_TEST);
    return { canvas, gl, triangles: compiled(gl, kTriangles, "corner", 4), lines: compiled(gl, kLines, "end", 3) };
  });

  /** The matrix from the scene to the screen, by columns. */
  const matrix = (aspect) => {
    const [c, s, d, e] = [Math.cos(camera.turn), Math.sin(camera.turn), Math.cos(camera.tilt), Math.sin(camera.tilt)];
    const rows = [[c, -s, 0], [e * s, e * c, d], [d * s, d * c, -e]]; // right, up, into the screen
    const f = 2.2 * Math.min(1, aspect), near = 0.05, far = 20; // a narrow canvas shows the whole scene, too
    const m = new Float32Array(16);
    for (let k = 0; k < 3; ++k) {
      m[4 * k] = f / aspect * rows[0][k];
      m[4 * k + 1] = f * rows[1][k];
      m[4 * k + 2] = rows[2][k] * (far + near) / (far - near);
      m[4 * k + 3] = rows[2][k];
    }
    m[14] = camera.distance * (far + near) / (far - near) - 2 * far * near / (far - near);
    m[15] = camera.distance;
    return m;
  };
  const draw = () => views.forEach((v) => {
    if (!v) return;
    const { gl, canvas } = v;
    const scale = devicePixelRatio || 1;
    canvas.width = Math.round(canvas.clientWidth * scale);
    canvas.height = Math.round(canvas.clientHeight * scale);
    gl.viewport(0, 0, canvas.width, canvas.height);
    gl.clearColor(0, 0, 0, 0); // the background is that of the page
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    const view = matrix(canvas.width / Math.max(1, canvas.height));
    for (const [part, mode] of [[v.triangles, gl.TRIANGLES], [v.lines, gl.LINES]]) {
      gl.useProgram(part.program);
      gl.bindVertexArray(part.array);
      gl.uniformMatrix4fv(part.view, false, view);
      gl.drawArrays(mode, 0, part.count);
    }
  });
  const turn = (right, down) => {
    camera.turn += right;
    camera.tilt = Math.max(-1.57, Math.min(1.57, camera.tilt + down));
    draw();
  };
  const zoom = (factor) => {
    camera.distance = Math.max(0.1, Math.min(10, camera.distance * factor));
    draw();
  };
  const kKeys = {
    ArrowLeft: () => turn(-0.1, 0), ArrowRight: () => turn(0.1, 0), ArrowUp: () => turn(0, -0.1), ArrowDown: () => turn(0, 0.1),
    "+": () => zoom(0.9), "-": () => zoom(1 / 0.9),
  };
  addEventListener("resize", draw);
  for (const canvas of canvases) {
    canvas.tabIndex = 0;
    canvas.addEventListener("pointerdown", (e) => canvas.setPointerCapture(e.pointerId));
    canvas.addEventListener("pointermove", (e) => { if (e.buttons) turn(e.movementX * 0.01, e.movementY * 0.01); });
    canvas.addEventListener("wheel", (e) => { e.preventDefault(); zoom(Math.exp(e.deltaY * 0.001)); }, { passive: false });
    canvas.addEventListener("keydown", (e) => { if (kKeys[e.key]) { e.preventDefault(); kKeys[e.key](); } });
  }

  /**
   * Gives a canvas its scene. `corners`: per corner of each triangle x, y, z and a number, 0 for bad to 1 for good, or -1
   * for the element that is pointed out. `ends`: x, y, z per end of each line.
   */
  const show = (which, corners, ends = new Float32Array()) => {
    canvases[which].dataset.triangles = corners.length / 12;
    canvases[which].dataset.lines = ends.length / 6;
    const v = views[which];
    if (!v) return;
    for (const [part, data] of [[v.triangles, corners], [v.lines, ends]]) {
      v.gl.bindBuffer(v.gl.ARRAY_BUFFER, part.buffer);
      v.gl.bufferData(v.gl.ARRAY_BUFFER, data, v.gl.STATIC_DRAW);
      part.count = data.length / part.size;
    }
  };
  return { show, draw, supported: views.every((v) => v !== null) };
};
