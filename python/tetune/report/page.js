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
  if (data.acceptance) {
    const { criteria, verdicts, rows, notes } = data.acceptance;
    $("acceptance").hidden = false;
    $("h-acceptance").textContent = `Acceptance: ${criteria}`;
    $("verdicts").textContent = `Before: ${verdicts[0]}; after: ${verdicts[1]}.` + notes.map((n) => ` Note: ${n}.`).join("");
    $("criteria").tBodies[0].append(...rows.map(row));
  }
  $("targets").hidden = data.targets.length === 0;
  $("targets").querySelector("tbody").append(...data.targets.map(row));
  $("warnings").hidden = data.warnings.length === 0;
  $("warnings").querySelector("ul").append(...data.warnings.map((w) => element("li", w)));

  // ---- theme
  let dark = matchMedia("(prefers-color-scheme: dark)").matches;
  const set_theme = () => {
    document.documentElement.dataset.theme = dark ? "dark" : "light";
    $("theme").textContent = dark ? "Light" : "Dark";
    $("theme").setAttribute("aria-label", `Switch to ${dark ? "light" : "dark"} colors`);
  };
  set_theme();

  const script = document.createElement("script");
  script.textContent = new TextDecoder().decode(await inflated($("plotly").textContent));
  document.head.append(script);
  const config = { displaylogo: false, responsive: true, modeBarButtonsToRemove: ["sendDataToCloud", "toImage"] };
  const kToolbar = 36; // the height that the toolbar takes above the chart, in pixels
  const layout = (more) => ({
    paper_bgcolor: css("back"), plot_bgcolor: css("back"), font: { color: css("text"), family: kFont, size: 13 },
    margin: { l: 60, r: 20, t: kToolbar, b: 45 }, legend: { orientation: "h", x: 0, y: 1.12 }, ...more,
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
      layout({ xaxis: axis("sweeps done"), yaxis: axis("energy"), yaxis2: second("flips"), margin: { l: 70, r: 60, t: kToolbar, b: 45 } }), config));
    const gradient = figure($("charts"), "Norm of the gradient over the sweeps",
      run.sweeps.length ? `From ${run.sweeps[0].gradient_norm2.toPrecision(3)} to ${run.sweeps.at(-1).gradient_norm2.toPrecision(3)} (squared).` : "No sweeps.");
    charts.push(() => Plotly.react(gradient, [flip_bars(), line("gradient", sweeps, run.sweeps.map((s) => s.gradient_norm2), "before")],
      layout({ xaxis: axis("sweep"), yaxis: axis("squared norm", { type: "log", exponentformat: "power" }), yaxis2: second("flips"), margin: { l: 70, r: 60, t: kToolbar, b: 45 } }), config));
    const steps = [...run.sweeps.map((s) => [`sweep ${s.iteration}`, s.dihedral_min_deg]),
      ...run.worst_rounds.map((w, i) => [`round ${i + 1}: ${w.work}`, w.dihedral_min_deg])].filter((s) => s[1] > 0);
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
  const views = make_views([$("view0"), $("view1")]);
  let place = null; // the worst element that is shown: [which mesh, row], or null for the whole mesh
  const names = ["x", "y", "z"];
  const plane = $("plane");
  plane.max = data.planes;
  plane.value = Math.ceil(data.planes / 2);
  const diameter = Math.hypot(...data.size) || 1;
  /** Appends the corners of triangles, those of `keep` or all: coordinates and color are parts of 65535 and of 255. */
  const append_triangles = (corners, { points, triangles, ...colors }, keep) => {
    const n = triangles.length / 3, vertices = points.length / 3;
    const color = colors[$("color").value];
    const append = (t) => {
      for (let k = 0; k < 3; ++k) {
        const v = triangles[k * n + t];
        for (let a = 0; a < 3; ++a) corners.push((points[a * vertices + v] / 65535 - 0.5) * data.size[a] / diameter);
        corners.push(color[t] / 255);
      }
    };
    for (let t = 0; t < n; ++t) if (!keep || keep(t)) append(t);
  };
  const show_cut = async (which) => {
    const scene = data.scenes[which];
    const a = Number($("axis").value);
    const p = Number(plane.value);
    const surface = await unpacked(scene.surface);
    const cut = a >= 0 && p < data.planes;
    const corners = [];
    append_triangles(corners, surface, cut ? (t) => surface["first" + a][t] <= p : null);
    if (cut) append_triangles(corners, await unpacked(scene.cuts[a][p]));
    views.show(which, Float32Array.from(corners));
  };
  const kFaces = [[1, 2, 3], [0, 3, 2], [0, 1, 3], [0, 2, 1]];
  const kEdges = [[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]];
  /** In its own mesh the element and the edges of what is around it, which would hide it; in the other what is around. */
  const show_place = async (which) => {
    const [of, r] = place;
    const { around, at: center, size } = data.worst[of][r];
    const { corners: vertices, ...colors } = await unpacked(around[which]);
    const color = colors[$("color").value];
    const mine = of === which;
    const corners = [], ends = [];
    for (let t = 0; 12 * t < vertices.length; ++t) {
      const at = (v, c) => (vertices[12 * t + 3 * v + c] - center[c]) / (3 * size);
      const shrunk = (v, c) => {
        const middle = (at(0, c) + at(1, c) + at(2, c) + at(3, c)) / 4;
        return middle + 0.85 * (at(v, c) - middle);
      };
      if (mine) for (const edge of kEdges) for (const v of edge) for (let c = 0; c < 3; ++c) ends.push(at(v, c));
      if (mine && t > 0) continue;
      for (const face of kFaces) {
        for (const v of face) {
          for (let c = 0; c < 3; ++c) corners.push(mine ? at(v, c) : shrunk(v, c));
          corners.push(mine ? -1 : color[t] / 255);
        }
      }
    }
    views.show(which, Float32Array.from(corners), Float32Array.from(ends));
  };

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
    const [low, high] = data.colors[$("color").value];
    const unit = $("color").value === "mean_ratio" ? "" : "°";
    $("lowest").textContent = `${low}${unit}`;
    $("highest").textContent = `${Number(high.toFixed(2))}${unit}, the best`;
    $("shown").textContent = !views.supported ? "This browser has no WebGL 2: the meshes cannot be drawn." : place === null ? "Drag to turn, scroll to zoom: both meshes follow."
      : `Element ${data.worst[place[0]][place[1]].tet} ${place[0] ? "after" : "before"}, in red, and what is around it in both meshes.`;
    for (const which of [0, 1]) await (place === null ? show_cut : show_place)(which);
    views.draw();
  }).catch((error) => { $("shown").textContent = `The mesh cannot be shown: ${error.message}`; console.error(error); }));

  const draw_all = () => { charts.forEach((c) => c()); return draw(); };
  await draw_all();
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
