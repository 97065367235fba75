// Error ellipses of a result: choose the sweep point, the propagations, the size, and how the axes are scaled.
const LOOKS = { monte_carlo: ["c0", ""], joint: ["c1", "9 4"], toolface_dependent: ["c1", "9 4"], systematic: ["c2", "5 3"],
  ti_systematic: ["c2", "5 3"], random: ["c3", "2 3"], ti_random: ["c3", "2 3"], predicted: ["c0", ""] };
const MORE_LOOKS = [["c4", "12 3 2 3"], ["c5", "7 2 2 2 2 2"], ["c6", "1 2"], ["c7", "4 2"], ["c1", "3 6"], ["c2", "14 4"]];

function ellipseExplorer(place, data, state) {
  const keys = data.keys.length;
  const width = Math.max(290, Math.min(640, place.clientWidth)), height = Math.max(300, 0.73 * width);
  const box = { left: width < 500 ? 64 : 84, top: 14, width: width - (width < 500 ? 76 : 104), height: height - 68 };
  const looks = {};
  let more = 0;
  for (const f of data.formulations) looks[f] = LOOKS[f] || MORE_LOOKS[more++ % MORE_LOOKS.length];

  const choosers = data.keys.map((k) => k.name === "md_m"
    ? state.kept(k.name, choice("measured depth (m)", k.values, draw, k.values.length - 1)) // the end of the well is what one asks for first
    : state.kept(k.name, choice(plain(k.name), k.values, draw)));
  const size = state.kept("size", choice("size", ["1σ", "2σ", "3σ"], draw, data.rows.length ? 1 : 0));
  const view = state.kept("axes", choice("axes", ["map, equal scales", "along and across the ellipse, own scales"], draw, needsOwnScales() ? 1 : 0));
  const BESIDE = ["joint", "toolface_dependent"]; // the figures beside the drawing are along the ellipses of these
  const cloud = Object.keys(data.clouds).length ? check("realisations", true, draw) : null;
  const boxes = data.formulations.map((f) => {
    const chosen = check(f.replace(/_/g, " "), true, draw);
    const sample = make("svg", { class: "sample", viewBox: "0 0 34 8", "aria-hidden": "true" }, [
      make("line", { x1: 1, x2: 33, y1: 4, y2: 4, class: looks[f][0], "stroke-dasharray": looks[f][1] })]);
    chosen.element.append(" ", sample);
    return chosen;
  });
  const drawing = make("svg", { viewBox: `0 0 ${width} ${height}`, width, height, role: "img" });
  const words = make("div", { class: "readout", "aria-live": "polite" }, [], true);
  const controls = [...choosers, size, view, ...(cloud ? [cloud] : [])].map((c) => c.element);
  const legend = [make("legend", {}, ["Monte Carlo and propagations"], true), ...boxes.map((b) => b.element)];
  place.append(make("div", { class: "controls" }, controls, true), make("fieldset", { class: "legend" }, legend, true),
    drawing, words);

  /** Whether most ellipses are so thin that a map with equal scales shows a line. */
  function needsOwnScales() {
    const thin = data.rows.filter((r) => r[keys + 4] < 0.06 * r[keys + 3]);
    return thin.length > data.rows.length / 2;
  }

  function draw() {
    const point = choosers.map((c) => c.get());
    const rows = data.rows.filter((r) => point.every((p, i) => r[i] === p));
    const shown = rows.filter((r) => boxes[r[keys]].get());
    const k = size.get() + 1, own = view.get() === 1;
    const of = (names) => rows.find((r) => names.includes(data.formulations[r[keys]]));
    const reference = of(BESIDE) || of(["monte_carlo"]) || rows[0];
    const bearing = own && reference ? reference[keys + 5] : 90; // of the abscissa: a map has east to the right
    const turn = (bearing * Math.PI) / 180;
    // (north, east) -> (abscissa, ordinate): along the bearing to the right, what is to its left upwards
    const place2 = (n, e) => [Math.cos(turn) * n + Math.sin(turn) * e, Math.sin(turn) * n - Math.cos(turn) * e];
    const curves = shown.map((r) => {
      const [dn, de, a, b, azimuth] = r.slice(keys + 1, keys + 6), t0 = (azimuth * Math.PI) / 180, points = [];
      for (let i = 0; i <= 180; ++i) {
        const t = (i * Math.PI) / 90, u = k * a * Math.cos(t), v = k * b * Math.sin(t);
        points.push(place2(dn + u * Math.cos(t0) - v * Math.sin(t0), de + u * Math.sin(t0) + v * Math.cos(t0)));
      }
      return points;
    });
    const dots = [], stored = cloud && cloud.get() ? data.clouds[point.join(",")] || [] : [];
    for (let i = 0; i + 1 < stored.length; i += 2) dots.push(place2(stored[i], stored[i + 1]));
    if (!curves.length) {
      drawing.replaceChildren(make("text", { x: width / 2, y: height / 2, "text-anchor": "middle" }, ["no ellipse here"]));
      words.replaceChildren();
      return;
    }
    const all = [...curves.flat(), ...dots];
    let limits = [0, 1].map((axis) => 1.06 * Math.max(1e-12, ...all.map((p) => Math.abs(p[axis]))));
    if (own) limits = limits.map((l, axis) => Math.max(l, 1e-9 * limits[1 - axis]));
    else {
      const scale = Math.max(limits[0] / box.width, limits[1] / box.height);
      limits = [scale * box.width, scale * box.height];
    }
    const centre = data.formulations.includes("monte_carlo") ? "from the Monte-Carlo mean" : "from the position";
    const up = own ? `Across, azimuth ${pretty((bearing + 270) % 360, 4)}° (m)` : "North (m)";
    const right = `${own ? `Along, azimuth ${pretty(bearing, 4)}°` : "East"} (m), ${centre}`;
    const axes = frame(box,
      { low: -limits[0], high: limits[0], ticks: ticks(-limits[0], limits[0], width / 90), label: right },
      { low: -limits[1], high: limits[1], ticks: ticks(-limits[1], limits[1], 6), label: up });
    drawing.replaceChildren(make("title", {}, [`Error ellipses, ${k}σ`]), axes.group);
    for (const [x, y] of dots) {
      drawing.append(make("circle", { cx: axes.px(x).toFixed(1), cy: axes.py(y).toFixed(1), r: 1.6, class: "dot" }));
    }
    curves.forEach((points, i) => {
      const name = data.formulations[shown[i][keys]];
      const path = points.map(([x, y], j) => `${j ? "L" : "M"}${axes.px(x).toFixed(2)} ${axes.py(y).toFixed(2)}`).join("");
      const [look, dashes] = looks[name];
      drawing.append(make("path", { d: path, class: `ellipse ${look}`, "stroke-dasharray": dashes, "data-formulation": name }));
    });
    words.replaceChildren(table(shown, k));
  }

  function table(rows, k) {
    const cell = (name, attributes, text) => make(name, attributes, [text], true);
    const line = (cells) => make("tr", {}, cells, true);
    const number = (v) => cell("td", { class: "n" }, v === null ? "–" : pretty(v, 4));
    const judged = rows.some((r) => r[keys + 6] !== null);
    const head = [`${k}σ major (m)`, `${k}σ minor (m)`, "azimuth (°)", ...(judged ? ["ratio major", "ratio minor"] : [])];
    const top = line([cell("th", {}, ""), ...head.map((h) => cell("th", { scope: "col", class: "n" }, h)),
      ...(judged ? [cell("th", { scope: "col" }, "verdict")] : [])]);
    const body = rows.map((r) => line([cell("th", { scope: "row" }, data.formulations[r[keys]].replace(/_/g, " ")),
      ...[k * r[keys + 3], k * r[keys + 4], r[keys + 5], ...(judged ? [r[keys + 6], r[keys + 7]] : [])].map(number),
      ...(judged ? [cell("td", {}, r[keys + 8])] : [])]));
    const whole = make("table", {}, [make("thead", {}, [top], true), make("tbody", {}, body, true)], true);
    return make("div", { class: "scroll", tabindex: 0, role: "region", "aria-label": "Ellipses that are drawn" }, [whole], true);
  }

  draw();
  const csv = () => [[...data.keys.map((k) => k.name), "formulation", "centre_north_m", "centre_east_m", "semi_major_m", "semi_minor_m", "major_azimuth_deg", "ratio_major", "ratio_minor", "verdict"],
    ...data.rows.map((r) => [...data.keys.map((k, i) => k.values[r[i]]), data.formulations[r[keys]], ...r.slice(keys + 1)])];
  place.append(savers(place.id, { svg: () => drawing, csv }));
}
