// SPDX-License-Identifier: Apache-2.0
"use strict";
// Runs the command line in a worker, on files in memory. Each command has an instance of the module of its own; where
// that has threads, they are workers of this one, and the command itself runs in one of them.
const command = async ({ wasm, module: module_script, thread }, words, files, on_line) => {
  const errors = [];
  let exit, abort;
  const exited = new Promise((resolve, reject) => { exit = resolve; abort = (reason) => reject(new Error(reason)); });
  const thread_script = thread && URL.createObjectURL(thread);
  const module = await tetune_module({
    wasmBinary: wasm, noInitialRun: true, mainScriptUrlOrBlob: module_script, locateFile: (name) => thread_script ?? name,
    print: (line) => on_line(line), printErr: (line) => { errors.push(line); on_line(line); },
    onExit: exit, onAbort: abort, quit: () => {},
  });
  module.FS.mkdir("/mesh");
  module.FS.chdir("/mesh");
  for (const [name, bytes] of Object.entries(files)) module.FS.writeFile(name, bytes);
  module.callMain(words);
  const code = await exited;
  const read = (name) => (module.FS.analyzePath(name).exists ? module.FS.readFile(name) : null);
  return { code, errors, read, names: () => module.FS.readdir(".").filter((n) => !n.startsWith(".")) };
};

/** Points and tetrahedra of a binary MEDIT file as the command line writes it. */
const parsed = (bytes) => {
  const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
  const version = view.getInt32(4, true);
  const wide = version >= 4 ? 8 : 4;
  const integer = (at, size) => (size === 8 ? Number(view.getBigInt64(at, true)) : view.getInt32(at, true));
  const mesh = {};
  for (let at = 8; at > 0 && at < bytes.length;) {
    const keyword = view.getInt32(at, true);
    if (keyword === 54) break;
    const place = version >= 3 ? 8 : 4;
    const next = integer(at + 4, place);
    at += 4 + place;
    if (keyword === 4) {
      const n = integer(at, wide);
      const real = version === 1 ? 4 : 8;
      mesh.points = new Float64Array(3 * n);
      at += wide;
      for (let v = 0; v < n; ++v, at += 3 * real + wide) {
        for (let c = 0; c < 3; ++c) mesh.points[3 * v + c] = real === 8 ? view.getFloat64(at + 8 * c, true) : view.getFloat32(at + 4 * c, true);
      }
    } else if (keyword === 8) {
      const n = integer(at, wide);
      mesh.tets = new Uint32Array(4 * n);
      at += wide;
      for (let t = 0; t < n; ++t, at += 5 * wide) {
        for (let c = 0; c < 4; ++c) mesh.tets[4 * t + c] = integer(at + c * wide, wide) - 1;
      }
    }
    at = next;
  }
  return mesh;
};

/** Turns tetrahedra that the file lists inside out. */
const turn = ({ points, tets }) => {
  let inverted = 0;
  for (let t = 0; t < tets.length; t += 4) {
    const [a, b, c] = [1, 2, 3].map((k) => [0, 1, 2].map((i) => points[3 * tets[t + k] + i] - points[3 * tets[t] + i]));
    const volume = a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0]) + a[2] * (b[0] * c[1] - b[1] * c[0]);
    inverted += volume < 0 ? 1 : 0;
  }
  if (8 * inverted <= tets.length) return;
  for (let t = 0; t < tets.length; t += 4) [tets[t + 2], tets[t + 3]] = [tets[t + 3], tets[t + 2]];
};

const kFaces = [[1, 2, 3], [0, 3, 2], [0, 1, 3], [0, 2, 1]];

/** The tetrahedron behind each face, or -1. Faces of the same smallest vertex are in one list. */
const neighbors_of = (tets) => {
  const count = tets.length;
  const low = new Uint32Array(count), mid = new Uint32Array(count), high = new Uint32Array(count);
  for (let face = 0; face < count; ++face) {
    const t = face & ~3, [i, j, k] = kFaces[face & 3];
    const a = tets[t + i], b = tets[t + j], c = tets[t + k];
    low[face] = Math.min(a, b, c);
    high[face] = Math.max(a, b, c);
    mid[face] = a + b + c - low[face] - high[face];
  }
  const first = new Int32Array(low.reduce((m, v) => Math.max(m, v), 0) + 1).fill(-1);
  const next = new Int32Array(count), neighbors = new Int32Array(count).fill(-1);
  for (let face = 0; face < count; ++face) {
    let before = -1, other = first[low[face]];
    for (; other >= 0 && (mid[other] !== mid[face] || high[other] !== high[face]); other = next[other]) before = other;
    if (other < 0) {
      next[face] = first[low[face]];
      first[low[face]] = face;
      continue;
    }
    neighbors[face] = other >> 2;
    neighbors[other] = face >> 2;
    if (before < 0) first[low[face]] = next[other];
    else next[before] = next[other];
  }
  return neighbors;
};

/** Smallest dihedral angle in degrees and mean ratio of each tetrahedron, zero for an inverted one; numbers of all
    dihedral angles by steps of two degrees. */
const measured = ({ points, tets }) => {
  const n = tets.length / 4;
  const angle = new Float32Array(n), ratio = new Float32Array(n), angles = new Float64Array(90);
  const p = [0, 1, 2, 3].map(() => [0, 0, 0]);
  const minus = (a, b) => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
  const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
  const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
  for (let t = 0; t < n; ++t) {
    for (let v = 0; v < 4; ++v) for (let c = 0; c < 3; ++c) p[v][c] = points[3 * tets[4 * t + v] + c];
    const e = [minus(p[1], p[0]), minus(p[2], p[0]), minus(p[3], p[0])];
    const volume = dot(e[0], cross(e[1], e[2])) / 6;
    if (!(volume > 0)) continue;
    const squares = [...e, minus(p[2], p[1]), minus(p[3], p[1]), minus(p[3], p[2])].reduce((sum, d) => sum + dot(d, d), 0);
    ratio[t] = 12 * (3 * volume) ** (2 / 3) / squares;
    const normal = kFaces.map(([a, b, c]) => cross(minus(p[b], p[a]), minus(p[c], p[a])));
    let smallest = 180;
    for (let i = 0; i < 4; ++i) {
      for (let j = 0; j < i; ++j) {
        const cosine = -dot(normal[i], normal[j]) / Math.sqrt(dot(normal[i], normal[i]) * dot(normal[j], normal[j]));
        const degrees = Math.acos(Math.max(-1, Math.min(1, cosine))) * 180 / Math.PI;
        ++angles[Math.min(89, Math.floor(degrees / 2))];
        smallest = Math.min(smallest, degrees);
      }
    }
    angle[t] = smallest;
  }
  return { angle, ratio, angles };
};

const scene = async (program, files, name) => {
  const done = await command(program, ["convert", name, "-o", "view.meshb"], files, () => {});
  const bytes = done.read("view.meshb");
  if (!bytes) throw new Error(done.errors.join("\n"));
  const mesh = parsed(bytes);
  if (!mesh.tets || !mesh.tets.length) throw new Error(`${name}: there is no tetrahedron to show`);
  turn(mesh);
  return { points: mesh.points, tets: mesh.tets, neighbors: neighbors_of(mesh.tets), ...measured(mesh) };
};
const send = (kind, s, more = {}) => postMessage({ kind, ...s, ...more }, [s.points, s.tets, s.neighbors, s.angle, s.ratio].map((a) => a.buffer));

onmessage = async ({ data: { program, files, input, output, words } }) => {
  try {
    if (!output) {
      send("before", await scene(program, files, input));
      return;
    }
    const start = performance.now();
    const options = ["--threads", String(program.threads), "--progress", "json", ...words];
    const done = await command(program, ["optimize", input, "-o", output, ...options], files, (line) => postMessage({ kind: "line", line }));
    const seconds = (performance.now() - start) / 1000;
    const results = Object.fromEntries(done.names().filter((n) => !(n in files) && done.read(n)).map((n) => [n, done.read(n)]));
    const reasons = done.errors.map((l) => (l.startsWith("{") ? JSON.parse(l) : { event: "error", text: l }))
      .filter(({ event }) => event === "error").map(({ text }) => text);
    if (!results[output]) throw new Error(reasons.join("\n") || `exit code ${done.code}`);
    send("after", await scene(program, results, output), { results, seconds });
  } catch (e) {
    postMessage({ kind: "error", message: e.message ?? String(e) });
  }
};
