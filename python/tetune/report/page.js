// SPDX-License-Identifier: Apache-2.0
"use strict";
(async () => {
  const $ = (id) => document.getElementById(id);
  const css = (name) => getComputedStyle(document.documentElement).getPropertyValue("--" + name).trim();
  const data = JSON.parse($("data").textContent);
  const Arrays = { uint8: Uint8Array, uint16: Uint16Array, uint32: Uint32Array, float32: Float32Array };

  const kFont = 'system-ui, "Segoe UI", Roboto, "Liberation Sans", sans-serif'; // as in the style sheet

  const inflated = async (text) => {
    const bytes = Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
    return new Response(new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"))).arrayBuffer();
  };
  /** Arrays of an object, unpacked the first time they are asked for. */
  const unpacked = async (packed) => {
    for (const [key, value] of Object.entries(packed)) {
      if (value.type) packed[key] = new Arrays[value.type](await inflated(value.data));
    }
    return packed;
  };

  const element = (tag, text, attributes = {}) => {
    const e = document.createElement(tag);
    e.textContent = text;
    for (const [name, value] of Object.entries(attributes)) e.setAttribute(name, value);
    return e;
  };
  const row = (cells) => {
    const tr = document.createElement("tr");
    cells.forEach((c, i) => tr.append(i === 0 ? element("th", c, { scope: "row" }) : element("td", c)));
    return tr;
  };
  $("figures").tBodies[0].append(...data.figures.map(row));
  $("changes").tBodies[0].append(...data.changes.map(row));

  // ---- theme
  let dark = matchMedia("(prefers-color-scheme: dark)").matches;
  const set_theme = () => {
    document.documentElement.dataset.theme = dark ? "dark" : "light";
    $("theme").textContent = dark ? "Light" : "Dark";
    $("theme").setAttribute("aria-label", `Switch to ${dark ? "light" : "dark"} colours`);
  };
  set_theme();

  const script = document.createElement("script");
  script.textContent = new TextDecoder().decode(await inflated($("plotly").textContent));
  document.head.append(script);
  const config = { displaylogo: false, responsive: true, modeBarButtonsToRemove: ["sendDataToCloud", "toImage"] };
  const layout = (more) => ({
    paper_bgcolor: css("back"), plot_bgcolor: css("back"), font: { color: css("text"), family: kFont, size: 13 },
    margin: { l: 60, r: 20, t: 10, b: 45 }, legend: { orientation: "h", x: 0, y: 1.12 }, ...more,
  });
  const axis = (title, more = {}) => ({ title: { text: title }, gridcolor: css("line"), zerolinecolor: css("line"), automargin: true, ...more });

  // ---- charts
  const figure = (parent, title, note) => {
    const f = document.createElement("figure");
    const caption = element("figcaption", title);
    caption.append(element("small", note));
    const chart = element("div", "", { class: "chart", role: "img", "aria-label": `${title}. ${note}` });
    f.append(caption, chart);
    parent.append(f);
    return chart;
  };
  const charts = [];
  const share_below = (h, limit) => h.shares.map((s) =>
    s.reduce((sum, v, i) => sum + (h.low + (i + 0.5) * h.width < limit ? v : 0), 0).toFixed(2));
  const notes = [
    (h) => { const [b, a] = share_below(h, 20); return `Below 20°: ${b} % of the elements before, ${a} % after.`; },
    (h) => { const [b, a] = share_below(h, 150); return `Above 150°: ${(100 - b).toFixed(2)} % of the elements before, ${(100 - a).toFixed(2)} % after.`; },
    (h) => { const [b, a] = share_below(h, 0.5); return `Below 0.5: ${b} % of the elements before, ${a} % after.`; },
  ];
  data.histograms.forEach((h, n) => {
    const x = h.shares[0].map((_, i) => h.low + (i + 0.5) * h.width);
    const bars = (name, k, color) => ({
      type: "bar", name, x, y: h.shares[k], width: h.width, opacity: 0.6, marker: { color: css(color), line: { width: 0 } },
      hovertemplate: "%{x:.4~g}: %{y:.3~g} %<extra>" + name + "</extra>",
    });
    const chart = figure($("histograms"), h.title, notes[n](h));
    charts.push(() => Plotly.react(chart, [bars("before", 0, "before"), bars("after", 1, "after")], layout({
      barmode: "overlay", bargap: 0, xaxis: axis(""),
      yaxis: axis("% of the elements", $("log").checked ? { type: "log" } : {}),
    }), config));
  });

  const run = data.optimization;
  if (run) {
    $("run").hidden = false;
    const flips = run.flips_2_3 + run.flips_3_2 + run.edge_removals + run.face_removals + run.boundary_flips;
    $("summary").textContent = `${run.sweeps.length} sweeps, ${flips.toLocaleString("en")} flips, ` +
      `${run.vertices_inserted} vertices inserted and ${run.vertices_removed} removed, in ${run.seconds.toFixed(2)} s on ${run.device}` +
      `${run.threads ? ` (${run.threads} threads)` : ""}; stopped: ${run.stopped}.`;
    const sweeps = run.sweeps.map((s) => s.iteration);
    const per_iteration = new Map();
    for (const p of run.flip_passes) {
      const sum = p.flips_2_3 + p.flips_3_2 + p.edge_removals + p.face_removals + p.boundary_flips;
      per_iteration.set(p.after_iteration, (per_iteration.get(p.after_iteration) ?? 0) + sum);
    }
    const flip_bars = () => ({
      type: "bar", name: "flips", x: [...per_iteration.keys()], y: [...per_iteration.values()], yaxis: "y2", opacity: 0.4,
      marker: { color: css("third") }, width: 0.5, hovertemplate: "after sweep %{x}: %{y} flips<extra></extra>",
    });
    const second = (title) => axis(title, { overlaying: "y", side: "right", showgrid: false, rangemode: "tozero", tickmode: "auto" });
    const line = (name, x, y, color) => ({ type: "scatter", mode: "lines+markers", name, x, y, line: { color: css(color), width: 2 } });
    const energies = run.sweeps.map((s) => s.energy_before).concat(run.energy_after);
    const energy = figure($("charts"), "Energy over the sweeps, and flips",
      `From ${run.energy_before.toPrecision(6)} to ${run.energy_after.toPrecision(6)}.`);
    charts.push(() => Plotly.react(energy, [flip_bars(), line("energy", energies.map((_, i) => i), energies, "after")],
      layout({ xaxis: axis("sweeps done"), yaxis: axis("energy"), yaxis2: second("flips"), margin: { l: 70, r: 60, t: 10, b: 45 } }), config));
    const gradient = figure($("charts"), "Norm of the gradient over the sweeps",
      run.sweeps.length ? `From ${run.sweeps[0].gradient_norm2.toPrecision(3)} to ${run.sweeps.at(-1).gradient_norm2.toPrecision(3)} (squared).` : "No sweeps.");
    charts.push(() => Plotly.react(gradient, [flip_bars(), line("gradient", sweeps, run.sweeps.map((s) => s.gradient_norm2), "before")],
      layout({ xaxis: axis("sweep"), yaxis: axis("squared norm", { type: "log", exponentformat: "power" }), yaxis2: second("flips"), margin: { l: 70, r: 60, t: 10, b: 45 } }), config));
    const steps = [...run.sweeps.map((s) => [`sweep ${s.iteration}`, s.dihedral_min_deg]),
      ...run.worst_rounds.map((w, i) => [`round ${i + 1}`, w.dihedral_min_deg])].filter((s) => s[1] > 0);
    if (steps.length) {
      const angle = figure($("charts"), "Smallest dihedral angle over sweeps and rounds on the worst elements",
        `From ${steps[0][1].toFixed(2)}° after the first sweep to ${steps.at(-1)[1].toFixed(2)}°.`);
      charts.push(() => Plotly.react(angle, [line("angle", steps.map((s) => s[0]), steps.map((s) => s[1]), "after")],
        layout({ showlegend: false, xaxis: axis("", { type: "category" }), yaxis: axis("degrees") }), config));
    }
    const phases = Object.entries(run.phase_seconds);
    const longest = phases.reduce((a, b) => (b[1] > a[1] ? b : a), ["", 0]);
    const times = figure($("charts"), "Time of each phase", `The longest: ${longest[0]}, ${longest[1].toFixed(2)} s.`);
    charts.push(() => Plotly.react(times, [{
      type: "bar", orientation: "h", y: phases.map((p) => p[0]), x: phases.map((p) => p[1]), marker: { color: css("after") },
      hovertemplate: "%{y}: %{x:.3f} s<extra></extra>",
    }], layout({ xaxis: axis("seconds"), yaxis: axis("", { autorange: "reversed" }) }), config));
  }

  // ---- 3D
  const views = [$("view0"), $("view1")];
  let place = null; // the worst element that is shown: [which mesh, row], or null for the whole mesh
  const names = ["x", "y", "z"];
  const plane = $("plane");
  plane.max = data.planes;
  plane.value = Math.ceil(data.planes / 2);
  const coordinates = (points) => names.map((_, a) => {
    const n = points.length / 3;
    return Float32Array.from(points.subarray(a * n, (a + 1) * n), (v) => data.low[a] + data.size[a] * v / 65535);
  });
  const mesh3d = ([x, y, z], i, j, k, color, bar) => {
    const name = $("color").value;
    const [lo, hi] = data.colors[name];
    return {
      type: "mesh3d", x, y, z, i, j, k, intensitymode: "cell", intensity: Float32Array.from(color, (c) => lo + (hi - lo) * c / 255),
      cmin: lo, cmax: hi, colorscale: "Viridis", flatshading: true, showscale: bar, hoverinfo: "skip",
      colorbar: { title: { text: name === "mean_ratio" ? "ratio" : "degrees" }, thickness: 12, len: 0.8 },
      lighting: { ambient: 0.65, diffuse: 0.55, specular: 0.05, roughness: 0.9 }, lightposition: { x: 1e4, y: -2e4, z: 3e4 },
    };
  };
  const columns = (all, keep) => {
    const n = all.length / 3;
    return [0, 1, 2].map((c) => (keep ? keep.map((t) => all[c * n + t]) : all.subarray(c * n, (c + 1) * n)));
  };
  const traces_of_cut = async (which) => {
    const scene = data.scenes[which];
    const a = Number($("axis").value);
    const p = Number(plane.value);
    const surface = await unpacked(scene.surface);
    const name = $("color").value;
    const bar = which === 1;
    const cut = a >= 0 && p < data.planes;
    let keep = null;
    if (cut) {
      keep = [];
      const first = surface["first" + a];
      for (let t = 0; t < first.length; ++t) if (first[t] <= p) keep.push(t);
      keep = Uint32Array.from(keep);
    }
    const color = keep ? keep.length ? Uint8Array.from(keep, (t) => surface[name][t]) : new Uint8Array() : surface[name];
    const traces = [mesh3d(coordinates(surface.points), ...columns(surface.triangles, keep), color, bar)];
    if (cut) {
      const inside = await unpacked(scene.cuts[a][p]);
      traces.push(mesh3d(coordinates(inside.points), ...columns(inside.triangles), inside[name], false));
    }
    return traces;
  };
  const kFaces = [[1, 2, 3], [0, 3, 2], [0, 1, 3], [0, 2, 1]];
  const kEdges = [[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]];
  const traces_of_place = async (which) => {
    const [of, r] = place;
    const around = await unpacked(data.worst[of][r].around[which]);
    const corners = around.corners;
    const count = corners.length / 12;
    const mine = of === which;
    const xyz = [0, 1, 2].map(() => new Float32Array(4 * count));
    const outline = [[], [], []];
    const others = [[], [], []];
    for (let t = 0; t < count; ++t) {
      for (let c = 0; c < 3; ++c) {
        const at = (v) => corners[12 * t + 3 * v + c];
        const middle = (at(0) + at(1) + at(2) + at(3)) / 4;
        for (let v = 0; v < 4; ++v) xyz[c][4 * t + v] = mine ? at(v) : middle + 0.85 * (at(v) - middle);
        for (const [v, w] of mine ? kEdges : []) (t === 0 ? outline : others)[c].push(at(v), at(w), null);
      }
    }
    const drawn = mine ? 1 : count; // the neighbours of the element would hide it: they are lines
    const corner = (m) => Uint32Array.from({ length: 4 * drawn }, (_, f) => 4 * Math.floor(f / 4) + kFaces[f % 4][m]);
    const color = Uint8Array.from({ length: 4 * drawn }, (_, f) => around[$("color").value][Math.floor(f / 4)]);
    const lines = ([x, y, z], color, width) => ({
      type: "scatter3d", mode: "lines", x, y, z, hoverinfo: "skip", showlegend: false, line: { color, width },
    });
    const traces = [mesh3d(xyz, corner(0), corner(1), corner(2), color, which === 1)];
    if (mine) traces.push(lines(others, css("faint"), 1), lines(outline, dark ? "#ff6b6b" : "#c00000", 6));
    return traces;
  };

  let camera = { eye: { x: 1.5, y: -1.35, z: 0.95 } };
  const three = () => ({
    paper_bgcolor: css("back"), font: { color: css("text"), family: kFont, size: 12 }, margin: { l: 0, r: 0, t: 0, b: 0 },
    uirevision: "kept",
    scene: {
      aspectmode: "data", camera, dragmode: "orbit",
      ...Object.fromEntries(names.map((n, a) => [n + "axis", {
        title: { text: n }, color: css("faint"), gridcolor: css("line"), showbackground: false, zeroline: false,
        ...(place ? {} : { range: [data.low[a], data.low[a] + data.size[a]] }),
      }])),
    },
  });
  let drawing = Promise.resolve();
  const draw = () => (drawing = drawing.then(async () => {
    const a = Number($("axis").value);
    const p = Number(plane.value);
    plane.disabled = a < 0 || place !== null;
    $("axis").disabled = place !== null;
    const where = a < 0 || p >= data.planes ? "whole" : `${names[a]} = ${(data.low[a] + data.size[a] * (p + 1) / (data.planes + 1)).toPrecision(4)}`;
    $("where").textContent = where;
    plane.setAttribute("aria-valuetext", where);
    $("whole").hidden = place === null;
    $("shown").textContent = place === null ? "Drag to turn, scroll to zoom: both meshes follow."
      : `Element ${data.worst[place[0]][place[1]].tet} ${place[0] ? "after" : "before"}, outlined, and what is around it in both meshes.`;
    for (const which of [0, 1]) {
      const traces = await (place === null ? traces_of_cut : traces_of_place)(which);
      await Plotly.react(views[which], traces, three(), config);
    }
  }).catch((error) => { $("shown").textContent = `The mesh cannot be shown: ${error.message}`; console.error(error); }));

  const draw_all = () => { charts.forEach((c) => c()); return draw(); };
  await draw_all();
  views.forEach((view, which) => view.on("plotly_relayout", (change) => {
    if (!change["scene.camera"]) return;
    camera = change["scene.camera"];
    const other = views[1 - which];
    if (JSON.stringify(other.layout.scene.camera) !== JSON.stringify(camera)) Plotly.relayout(other, { "scene.camera": camera });
  }));
  for (const id of ["axis", "color", "plane"]) $(id).addEventListener("input", draw);
  $("controls").addEventListener("submit", (e) => e.preventDefault());
  $("log").addEventListener("change", () => charts.forEach((c) => c()));
  $("theme").addEventListener("click", () => { dark = !dark; set_theme(); draw_all(); });
  const show = (of, r) => {
    place = of < 0 ? null : [of, r];
    document.querySelectorAll("tr[data-worst]").forEach((tr) =>
      tr.setAttribute("aria-current", String(tr.dataset.worst === `${of} ${r}`)));
    return draw();
  };
  $("whole").addEventListener("click", () => show(-1));

  data.worst.forEach((list, of) => {
    const table = $("worst" + of);
    const head = table.createTHead().insertRow();
    for (const title of ["Element", "Smallest angle", "Mean ratio", "At", ""]) head.append(element("th", title, { scope: "col" }));
    const body = table.createTBody();
    list.forEach((w, r) => {
      const tr = row([String(w.tet), `${w.angle.toFixed(2)}°`, w.ratio.toFixed(4), w.at.map((v) => Number(v.toPrecision(3))).join(", ")]);
      tr.dataset.worst = `${of} ${r}`;
      const button = element("button", "Show", { type: "button", "aria-label": `Show element ${w.tet} ${of ? "after" : "before"}` });
      button.addEventListener("click", () => { show(of, r); $("h-mesh").scrollIntoView(); });
      const cell = tr.insertCell();
      cell.append(button);
      body.append(tr);
    });
  });
  document.documentElement.dataset.ready = "true";
})();
