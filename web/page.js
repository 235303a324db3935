// SPDX-License-Identifier: Apache-2.0
"use strict";
(async () => {
  const $ = (id) => document.getElementById(id);
  const inflated = async (text) => {
    const bytes = Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
    return new Response(new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"))).arrayBuffer();
  };
  // A browser isolates a page, and gives it threads, for two headers of the server, or of a service worker in its place.
  // The first time the page has to be loaded again; also where a forced reload has passed over a worker that is active,
  // once, as tools of developers may do that each time.
  if (crossOriginIsolated) {
    history.replaceState(null, "");
  } else if (location.protocol.startsWith("http") && navigator.serviceWorker && !navigator.serviceWorker.controller) {
    navigator.serviceWorker.addEventListener("controllerchange", () => location.reload());
    navigator.serviceWorker.register("isolate.js").then(({ active }) => {
      if (!active || history.state === "reloaded") return;
      history.replaceState("reloaded", "");
      location.reload();
    }).catch(() => {});  // this file alone is on the server: one thread
  }
  const script_of = (...texts) => new Blob(texts, { type: "text/javascript" });
  /** The module of the command line: with threads where the page is isolated, else the one within the page. */
  const program = await (async () => {
    const response = crossOriginIsolated ? await fetch("threads.json").catch(() => null) : null;
    const { wasm, module, thread } = response?.ok ? await response.json() :
      { wasm: $("wasm").textContent, module: $("module").textContent };
    return { wasm: await inflated(wasm), module: script_of(module), thread: thread && script_of(thread), threads: thread ? navigator.hardwareConcurrency : 1 };
  })();
  const script = URL.createObjectURL(script_of(program.module, $("worker").textContent));
  const scenes = [null, null];
  let files = {}, warnings = [], input = null, worker = null, place = null, opened = 0;
  const status = (text) => { $("status").textContent = text; };

  // ---- 3D
  const views = make_views([$("view0"), $("view1")]);
  const kFaces = [[1, 2, 3], [0, 3, 2], [0, 1, 3], [0, 2, 1]];
  const middle = (s, t, c) => (s.points[3 * s.tets[4 * t] + c] + s.points[3 * s.tets[4 * t + 1] + c] +
    s.points[3 * s.tets[4 * t + 2] + c] + s.points[3 * s.tets[4 * t + 3] + c]) / 4;
  const box_of = (s) => {
    const low = [Infinity, Infinity, Infinity], high = [-Infinity, -Infinity, -Infinity];
    s.points.forEach((v, i) => { low[i % 3] = Math.min(low[i % 3], v); high[i % 3] = Math.max(high[i % 3], v); });
    return { low, high, middle: low.map((v, c) => (v + high[c]) / 2), size: Math.hypot(...low.map((v, c) => high[c] - v)) || 1 };
  };
  /** Shows the faces between drawn tetrahedra and others. */
  const fill = (which) => {
    const s = scenes[which];
    if (!s) return;
    const box = scenes[0].box;
    const axis = Number($("axis").value);
    const at = axis < 0 ? 0 : box.low[axis] + (box.high[axis] - box.low[axis]) * $("plane").value / 1000;
    const n = s.tets.length / 4;
    const kept = new Uint8Array(n);
    const cut = Math.max(axis, 0);
    for (let t = 0; t < n; ++t) {
      if (place) {
        const d = Math.hypot(...[0, 1, 2].map((c) => middle(s, t, c) - place.at[c]));
        kept[t] = d < 3 * place.size && middle(s, t, cut) <= place.at[cut] ? 1 : 0;
      } else {
        kept[t] = axis < 0 || middle(s, t, axis) <= at ? 1 : 0;
      }
    }
    if (place && place.which === which) kept[place.tet] = 1;
    const center = place ? place.at : box.middle, size = place ? 6 * place.size : box.size;
    const each = s[$("color").value], scale = $("color").value === "angle" ? 1 / 70.53 : 1;
    let count = 0;
    const shown = (f) => kept[f >> 2] && (s.neighbors[f] < 0 || !kept[s.neighbors[f]]);
    for (let f = 0; f < 4 * n; ++f) count += shown(f) ? 3 : 0;
    const data = new Float32Array(4 * count);
    let i = 0;
    for (let f = 0; f < 4 * n; ++f) {
      if (!shown(f)) continue;
      const t = f >> 2;
      for (const k of kFaces[f & 3]) {
        for (let c = 0; c < 3; ++c) data[i++] = (s.points[3 * s.tets[4 * t + k] + c] - center[c]) / size;
        data[i++] = place && place.which === which && place.tet === t ? -1 : each[t] * scale;
      }
    }
    views.show(which, data);
  };
  const refresh = () => {
    fill(0);
    fill(1);
    views.draw();
    const angle = $("color").value === "angle";
    $("lowest").textContent = angle ? "0°" : "0";
    $("highest").textContent = angle ? "70.53°, the best" : "1, the best";
  };

  // ---- figures
  const sized = (canvas) => {
    const scale = devicePixelRatio || 1;
    canvas.width = Math.round(canvas.clientWidth * scale);
    canvas.height = Math.round(canvas.clientHeight * scale);
    return scale;
  };
  /** Shares before and after; `binned` are the numbers of a scene, from 0 to `high`. */
  const histogram = (canvas, binned, high, unit) => {
    const scale = sized(canvas);
    const g = canvas.getContext("2d");
    g.scale(scale, scale);
    const width = canvas.clientWidth, bottom = canvas.clientHeight - 22;
    const shares = scenes.map((s) => {
      if (!s) return [];
      const counts = binned(s), sum = counts.reduce((a, c) => a + c, 0) || 1;
      return Array.from(counts, (c) => c / sum);
    });
    const top = Math.max(1e-9, ...shares.flat());
    shares.forEach((each, which) => {
      g.fillStyle = which ? "#1f6fb2a0" : "#b35900a0";
      const step = width / each.length;
      each.forEach((c, i) => g.fillRect(i * step, bottom * (1 - c / top), Math.max(1, step - 1), bottom * c / top));
    });
    g.fillStyle = "#59636e";
    g.font = "13px sans-serif";
    g.fillRect(0, bottom, width, 1);
    for (let i = 0; i <= 6; ++i) {
      g.textAlign = i === 0 ? "left" : i === 6 ? "right" : "center";
      g.fillText(`${Number((high * i / 6).toFixed(2))}${unit}`, width * i / 6, bottom + 17);
    }
  };
  const ratios = (s) => {
    const counts = new Float64Array(60);
    for (const q of s.ratio) ++counts[Math.max(0, Math.min(59, Math.floor(q * 60)))];
    return counts;
  };
  const kWorst = 8;
  const show_worst = (which) => {
    const s = scenes[which], table = $("worst" + which).tBodies[0];
    table.querySelectorAll("tr").forEach((r) => r.remove());
    if (!s) return;
    const order = [];
    for (let t = 0; t < s.angle.length; ++t) {
      if (order.length === kWorst && s.angle[t] >= s.angle[order[kWorst - 1]]) continue;
      const i = order.findIndex((o) => s.angle[t] < s.angle[o]);
      order.splice(i < 0 ? order.length : i, 0, t);
      order.length = Math.min(order.length, kWorst);
    }
    for (const t of order) {
      const row = table.insertRow();
      for (const text of [t + 1, `${s.angle[t].toFixed(2)}°`, s.ratio[t].toFixed(4)]) row.insertCell().textContent = text;
      const button = document.createElement("button");
      button.type = "button";
      button.textContent = "Show";
      button.setAttribute("aria-label", `Show element ${t + 1} ${which ? "after" : "before"}`);
      button.addEventListener("click", () => {
        const at = [0, 1, 2].map((c) => middle(s, t, c));
        const size = Math.max(...[0, 1, 2, 3].map((k) => Math.hypot(...at.map((a, c) => s.points[3 * s.tets[4 * t + k] + c] - a))));
        place = { which, tet: t, at, size: size || 1e-9 };
        $("whole").hidden = false;
        refresh();
        $("cut").scrollIntoView();
      });
      row.insertCell().append(button);
    }
  };
  const charts = () => { histogram($("histogram0"), (s) => s.angles, 180, "°"); histogram($("histogram1"), ratios, 1, ""); };
  const show_all = () => { [0, 1].forEach(show_worst); charts(); refresh(); };

  // ---- runs
  const stop = () => {
    worker?.terminate();
    worker = null;
    $("cancel").disabled = true;
    $("start").disabled = !scenes[0];
  };
  const work = (message, done) => {
    stop();
    warnings = [];
    $("start").disabled = true;
    $("cancel").disabled = false;
    worker = new Worker(script);
    worker.onerror = (e) => { stop(); status(`The program failed: ${e.message}`); };
    worker.onmessage = ({ data }) => {
      if (data.kind === "line") {
        if (!data.line.startsWith("{")) return;
        const { event, phase, iteration, text } = JSON.parse(data.line);
        if (event === "warning") warnings.push(text);
        if (event === "progress") status(`Optimizing: ${phase ?? ""}${iteration === undefined ? "" : `, sweep ${iteration}`}`);
      } else if (data.kind === "error") {
        stop();
        status(data.message);
      } else {
        stop();
        done(data);
      }
    };
    worker.postMessage({ program, files, ...message });
  };
  const angle_of = (s) => s.angle.reduce((a, b) => Math.min(a, b), 180).toFixed(2);
  /** Links to the files of a result, in place of those before. */
  const offer = (results) => {
    for (const a of $("downloads").children) URL.revokeObjectURL(a.href);
    $("downloads").replaceChildren(...Object.entries(results).map(([name, bytes]) => {
      const a = document.createElement("a");
      a.href = URL.createObjectURL(new Blob([bytes]));
      a.download = a.textContent = name;
      return a;
    }));
  };
  const open = async (list) => {
    stop();
    const number = ++opened;
    const read = await Promise.all(Array.from(list, async (f) => [f.name, new Uint8Array(await f.arrayBuffer())]));
    if (number !== opened) return;  // others were opened meanwhile
    files = Object.fromEntries(read);
    const names = Object.keys(files);
    input = names.find((n) => n.endsWith(".ele")) ?? names[0];
    place = scenes[0] = scenes[1] = null;
    $("whole").hidden = true;
    offer({});
    [0, 1].forEach((which) => views.show(which, new Float32Array()));
    views.draw();
    status(`Reading ${input}`);
    work({ input }, (data) => {
      scenes[0] = { ...data, box: box_of(data) };
      $("start").disabled = false;
      show_all();
      status(`${input}: ${(data.tets.length / 4).toLocaleString("en")} tetrahedra, smallest dihedral angle ${angle_of(data)}°.`);
    });
  };
  $("start").addEventListener("click", () => {
    const dot = input.lastIndexOf(".");
    const output = `${input.slice(0, dot)}-optimized${input.slice(dot)}`;
    status("Optimizing");
    work({ input, output, words: ["--boundary", $("boundary").value, "--effort", $("effort").value] }, (data) => {
      scenes[1] = data;
      offer(data.results);
      show_all();
      status(`Done in ${data.seconds.toFixed(1)} s${program.threads > 1 ? ` with ${program.threads} threads` : ""}: smallest dihedral angle ${angle_of(scenes[0])}° before, ${angle_of(data)}° after.${warnings.map((w) => `\nWarning: ${w}`).join("")}`);
    });
  });
  $("cancel").addEventListener("click", () => { stop(); status("Canceled."); });
  $("file").addEventListener("change", (e) => { if (e.target.files.length) open(e.target.files); });
  const drop = $("drop");
  addEventListener("dragover", (e) => { e.preventDefault(); drop.classList.add("over"); });
  addEventListener("dragleave", () => drop.classList.remove("over"));
  addEventListener("drop", (e) => {
    e.preventDefault();
    drop.classList.remove("over");
    if (e.dataTransfer.files.length) open(e.dataTransfer.files);
  });
  for (const id of ["axis", "plane", "color"]) $(id).addEventListener("input", refresh);
  $("whole").addEventListener("click", () => { place = null; $("whole").hidden = true; refresh(); });
  addEventListener("resize", charts);
  document.querySelectorAll("form").forEach((f) => f.addEventListener("submit", (e) => e.preventDefault()));
  refresh();
  if (!views.supported) status("This browser has no WebGL 2: meshes are optimized, but not drawn.");
  document.documentElement.dataset.ready = "true";
})();
