// Maps of a result: choose the map, its axes, and the point along all other axes.
const SEQUENTIAL = ["00204d", "00336f", "39486b", "575d6d", "707173", "8a8779", "a69d75", "c4b56c", "e4cf5b", "ffea46"]; // cividis
const DIVERGING = ["08306b", "2171b5", "6baed6", "c6dbef", "f7f7f0", "fdd0a2", "fdae6b", "e6550d", "7f2704"];
const colour = (stops) => {
  const rgb = stops.map((s) => [0, 2, 4].map((i) => parseInt(s.slice(i, i + 2), 16)));
  return (t) => {
    const x = Math.min(1, Math.max(0, t)) * (rgb.length - 1), i = Math.min(rgb.length - 2, Math.floor(x));
    return rgb[i].map((c, j) => Math.round(c + (x - i) * (rgb[i + 1][j] - c)));
  };
};

/** 16-bit floats from base64. */
function halves(text) {
  const bytes = Uint8Array.from(atob(text), (c) => c.charCodeAt(0)), found = new Float64Array(bytes.length / 2);
  for (let i = 0; i < found.length; ++i) {
    const h = bytes[2 * i] | (bytes[2 * i + 1] << 8), sign = h & 0x8000 ? -1 : 1, e = (h >> 10) & 31, f = h & 1023;
    found[i] = e === 0 ? sign * f * 2 ** -24 : e === 31 ? (f ? NaN : sign * Infinity) : sign * (1 + f / 1024) * 2 ** (e - 15);
  }
  return found;
}

function mapExplorer(place, data, state) {
  const width = Math.max(290, Math.min(640, place.clientWidth)), narrow = width < 500, left = narrow ? 54 : 74;
  const box = { left, top: 32, width: width - left - (narrow ? 96 : 110), height: narrow ? 260 : 440 }, height = box.height + 88;
  const nice = (axis) => `${plain(axis.name)}${unitText(axis.unit) ? ` (${unitText(axis.unit)})` : ""}`;
  const which = state.kept("map", choice("map", data.maps.map((m) => plain(m.name)), remake, startMap()));
  const same = check("same colours for all points", false, draw), lines = check("contours", true, draw);
  const top = make("div", { class: "controls" }, [which.element], true), rest = make("div", { class: "controls" }, [], true);
  const drawing = make("svg", { viewBox: `0 0 ${width} ${height}`, width, height, role: "img", tabindex: 0, class: "map" });
  const words = make("p", { class: "readout", "aria-live": "polite" }, [], true), about = make("p", { class: "small" }, [], true);
  place.append(top, rest, drawing, words, about);
  let map, values, along, across, others, cursor = null, shown = null;

  function startMap() {
    return Math.max(0, data.maps.findIndex((m) => /minimal_detectable|ratio/.test(m.name)));
  }

  /** A new map: its values, and the controls of its axes. */
  function remake() {
    map = data.maps[which.get()];
    values = halves(map.data);
    const long = map.axes.filter((a) => data.axes[a].number && data.axes[a].values.length > 1);
    const longestFirst = [...long].sort((a, b) => data.axes[b].values.length - data.axes[a].values.length || b - a);
    const ranked = longestFirst.slice(0, 2).sort((a, b) => b - a);
    const names = long.map((a) => plain(data.axes[a].name));
    state.forget(["map"]);
    across = state.kept("right", choice("to the right", names, axesChanged, Math.max(0, long.indexOf(ranked[0]))));
    along = long.length > 1 ? state.kept("up", choice("upwards", names, axesChanged, Math.max(0, long.indexOf(ranked[1])))) : null;
    map.long = long;
    axesChanged();
  }

  function axesChanged() {
    const x = map.long[across.get()];
    let y = along ? map.long[along.get()] : null;
    if (y === x) y = map.long.find((a) => a !== x);
    map.x = x;
    map.y = y;
    const texts = (a) => data.axes[a].values.map((v) => (typeof v === "string" ? v : pretty(v, 6)));
    others = map.axes.filter((a) => a !== x && a !== y && data.axes[a].values.length > 1)
      .map((a) => ({ axis: a, choice: choice(nice(data.axes[a]), texts(a), draw) }));
    state.forget(["map", "right", "up"]);
    for (const o of others) state.kept(data.axes[o.axis].name, o.choice);
    const elements = [across, ...(along ? [along] : []), ...others.map((o) => o.choice), same, ...(map.y === null ? [] : [lines])].map((c) => c.element);
    rest.replaceChildren(...elements);
    cursor = null;
    draw();
  }

  /** The value at index i of the abscissa and j of the ordinate, at the chosen point of all other axes. */
  function at(i, j) {
    let offset = 0;
    for (const a of map.axes) {
      const other = others.find((o) => o.axis === a);
      offset = offset * data.axes[a].values.length + (a === map.x ? i : a === map.y ? j : other ? other.choice.get() : 0);
    }
    return values[offset] * map.scale;
  }

  function draw() {
    const xs = data.axes[map.x].values, ys = map.y === null ? [0] : data.axes[map.y].values, here = [];
    for (let j = 0; j < ys.length; ++j) for (let i = 0; i < xs.length; ++i) here.push(at(i, j));
    const finite = (same.get() ? Array.from(values, (v) => v * map.scale) : here).filter(Number.isFinite);
    shown = { xs, ys, here };
    about.textContent = `${map.text}${data.axes.some((a) => a.step > 1) ? "; thinned for this page, the file has all points" : ""}`;
    drawing.replaceChildren(make("title", {}, [`${plain(map.name)} over ${plain(data.axes[map.x].name)}`]));
    drawing.append(make("text", { x: box.left, y: 18, class: "label" }, [nice(map)]));
    if (map.y === null) curve(xs, here, finite);
    else image(xs, ys, here, scaleOf(finite));
    readout();
  }

  /** How values become colours: logarithmic over decades, about 1 for ratios, about 0 where there are both signs. */
  function scaleOf(finite) {
    if (!finite.length) return { of: () => 0, low: 0, high: 1, colours: colour(SEQUENTIAL), ticks: [] };
    let low = Infinity, high = -Infinity;
    for (const v of finite) { low = Math.min(low, v); high = Math.max(high, v); }
    if (/ratio/.test(map.name) && low > 0) {
      const most = Math.max(Math.log(1.05), Math.min(Math.log(10), Math.max(Math.abs(Math.log(low)), Math.abs(Math.log(high)))));
      const round = most > Math.log(2.5) ? [0.1, 0.2, 0.5, 1, 2, 5, 10] : [0.5, 0.7, 0.8, 0.9, 0.95, 1, 1.05, 1.1, 1.25, 1.4, 2];
      const shown = round.filter((v) => Math.abs(Math.log(v)) <= most + 1e-9);
      return { of: (v) => 0.5 + Math.log(v) / most / 2, colours: colour(DIVERGING), ticks: shown };
    }
    if (low < 0 && high > 0) {
      const sizes = finite.map(Math.abs).sort((a, b) => a - b), most = sizes[Math.floor(0.98 * (sizes.length - 1))] || high;
      return { of: (v) => 0.5 + v / most / 2, colours: colour(DIVERGING), ticks: ticks(-most, most, 6) };
    }
    if (low > 0 && high / low > 30) {
      const decades = Math.log10(high / low);
      return { of: (v) => Math.log10(v / low) / decades, colours: colour(SEQUENTIAL), ticks: logTicks(low, high) };
    }
    if (high === low) high = low + (Math.abs(low) || 1) * 1e-3;
    return { of: (v) => (v - low) / (high - low), colours: colour(SEQUENTIAL), ticks: ticks(low, high, 6) };
  }

  /** An axis; logarithmic where its values span decades. edges: of its cells, halfway between the values. */
  function axisOf(a) {
    const v = data.axes[a].values, log = v[0] > 0 && v[v.length - 1] / v[0] > 30 && data.axes[a].unit !== "deg";
    const of = log ? Math.log10 : (x) => x, back = log ? (x) => 10 ** x : (x) => x, n = v.length;
    const between = v.slice(1).map((x, i) => back((of(x) + of(v[i])) / 2));
    const edges = [back(2 * of(v[0]) - of(between[0])), ...between, back(2 * of(v[n - 1]) - of(between[n - 2]))];
    const marks = log ? logTicks(edges[0], edges[n]) : (data.axes[a].unit === "deg" ? angleTicks : ticks)(v[0], v[n - 1], width / 90);
    return { low: edges[0], high: edges[n], edges, of, back, label: nice(data.axes[a]), ticks: marks };
  }

  /** For each of `count` pixels along an axis, the number of its cell. */
  function cellsAlong(axis, count) {
    const low = axis.of(axis.low), step = (axis.of(axis.high) - low) / count, found = [];
    for (let i = 0, k = 0; i < count; ++i) {
      while (k < axis.edges.length - 2 && axis.back(low + (i + 0.5) * step) > axis.edges[k + 1]) ++k;
      found.push(k);
    }
    return found;
  }

  function image(xs, ys, here, scale) {
    const x = axisOf(map.x), y = axisOf(map.y), across = cellsAlong(x, 2 * box.width), down = cellsAlong(y, 2 * box.height).reverse();
    const canvas = make("canvas", { width: across.length, height: down.length }, [], true), paint = canvas.getContext("2d");
    const pixels = paint.createImageData(canvas.width, canvas.height), white = [255, 255, 255], hatch = [[120, 120, 120], [214, 214, 214]];
    const colours = here.map((v) => (Number.isFinite(v) ? scale.colours(scale.of(v)) : Number.isNaN(v) ? white : null));
    for (let j = 0, at = 0; j < down.length; ++j) for (let i = 0; i < across.length; ++i, at += 4) {
      const rgb = colours[down[j] * xs.length + across[i]] || hatch[(i + j) % 12 < 4 ? 0 : 1];
      pixels.data[at] = rgb[0];
      pixels.data[at + 1] = rgb[1];
      pixels.data[at + 2] = rgb[2];
      pixels.data[at + 3] = 255;
    }
    paint.putImageData(pixels, 0, 0);
    const axes = frame(box, x, y), whole = { x: box.left, y: box.top, width: box.width, height: box.height };
    drawing.append(make("image", { ...whole, preserveAspectRatio: "none", href: canvas.toDataURL(), class: "cells" }), axes.group);
    if (lines.get() && Math.min(xs.length, ys.length) > 5) { // lines between a few wide cells say more than the cells
      for (const level of scale.ticks) drawing.append(...contour(xs, ys, here, level, scale, axes));
    }
    colourBar(scale, here.some((v) => Math.abs(v) === Infinity));
    if (cursor) {
      const cross = `M${axes.px(xs[cursor[0]])} ${box.top}v${box.height}M${box.left} ${axes.py(ys[cursor[1]])}h${box.width}`;
      drawing.append(make("path", { d: cross, class: "cursor" }));
    }
    shown.axes = axes;
  }

  /** The lines where a map has this value (marching squares, linear along the edges of the grid on the scale of the colours), and the
   *  value at the longest of them. */
  function contour(xs, ys, here, level, scale, axes) {
    const n = xs.length, value = (i, j) => here[j * n + i], high = (i, j) => value(i, j) >= level, joins = new Map();
    const sx = xs.map(axes.px), sy = ys.map(axes.py), spots = new Map();
    /** The crossing on the edge from (i, j) to the right (kind 0) or up (kind 1). */
    const crossing = (i, j, kind) => {
      const key = 2 * (j * n + i) + kind;
      if (!spots.has(key)) {
        const [k, l] = kind ? [i, j + 1] : [i + 1, j], a = scale.of(value(i, j)), b = scale.of(value(k, l));
        const t = b === a ? 0.5 : Math.min(1, Math.max(0, (scale.of(level) - a) / (b - a)));
        spots.set(key, [sx[i] + t * (sx[k] - sx[i]), sy[j] + t * (sy[l] - sy[j])]);
      }
      return key;
    };
    const join = (a, b) => { for (const [p, q] of [[a, b], [b, a]]) joins.has(p) ? joins.get(p).push(q) : joins.set(p, [q]); };
    for (let j = 0; j + 1 < ys.length; ++j) for (let i = 0; i + 1 < n; ++i) {
      if (![value(i, j), value(i + 1, j), value(i, j + 1), value(i + 1, j + 1)].every(Number.isFinite)) continue;
      const sides = [];
      if (high(i, j) !== high(i + 1, j)) sides.push(crossing(i, j, 0));
      if (high(i + 1, j) !== high(i + 1, j + 1)) sides.push(crossing(i + 1, j, 1));
      if (high(i, j + 1) !== high(i + 1, j + 1)) sides.push(crossing(i, j + 1, 0));
      if (high(i, j) !== high(i, j + 1)) sides.push(crossing(i, j, 1));
      if (sides.length === 2) join(...sides);
      if (sides.length === 4) { // a saddle: by the mean of its corners
        const mean = (value(i, j) + value(i + 1, j) + value(i, j + 1) + value(i + 1, j + 1)) / 4;
        (mean >= level) === high(i, j) ? (join(sides[0], sides[1]), join(sides[2], sides[3])) : (join(sides[0], sides[3]), join(sides[1], sides[2]));
      }
    }
    const paths = [], seen = new Set();
    const walk = (start) => {
      const line = [];
      for (let k = start; k !== undefined; k = joins.get(k).find((m) => !seen.has(m))) {
        seen.add(k);
        line.push(k);
      }
      if (line.length > 2 && joins.get(line[line.length - 1]).includes(start)) line.push(start);
      paths.push(line.map((k) => spots.get(k)));
    };
    for (const [key, to] of joins) if (to.length === 1 && !seen.has(key)) walk(key); // open lines from their ends, then closed ones
    for (const key of joins.keys()) if (!seen.has(key)) walk(key);
    if (!paths.length) return [];
    const d = paths.map((line) => line.map(([x, y], i) => `${i ? "L" : "M"}${x.toFixed(1)} ${y.toFixed(1)}`).join("")).join("");
    const longest = paths.reduce((a, b) => (b.length > a.length ? b : a)), [x, y] = longest[Math.floor(longest.length / 2)];
    const strong = /ratio/.test(map.name) && level === 1 ? " strong" : "", label = [];
    if (longest.length > 8 && x > box.left + 20 && x < box.left + box.width - 20) {
      label.push(make("text", { x, y: y + 4, "text-anchor": "middle", class: "level" }, [pretty(level, 3)]));
    }
    return [make("path", { d, class: "contour halo" }), make("path", { d, class: `contour${strong}` }), ...label];
  }

  function colourBar(scale, infinite) {
    const x = box.left + box.width + 22, top = box.top + 20, tall = box.height - (infinite ? 60 : 24);
    for (let i = 0; i < 80; ++i) {
      const [r, g, b] = scale.colours(1 - (i + 0.5) / 80);
      drawing.append(make("rect", { x, y: top + (tall * i) / 80, width: 18, height: tall / 80 + 0.5, fill: `rgb(${r},${g},${b})` }));
    }
    for (const t of scale.ticks) {
      const y = top + tall * (1 - scale.of(t));
      if (y >= top - 1 && y <= top + tall + 1) drawing.append(make("text", { x: x + 24, y: y + 4 }, [pretty(t, 3)]));
    }
    drawing.append(make("text", { x: x - 4, y: box.top + 8, class: "label" }, [map.unit.length > 8 ? "" : unitText(map.unit) || "(no unit)"]));
    if (!infinite) return;
    drawing.append(make("rect", { x, y: top + tall + 16, width: 18, height: 16, fill: "#b0b0b0", class: "frame" }),
      make("text", { x: x + 24, y: top + tall + 29 }, ["∞"]));
  }

  const wide = () => width - box.left - 20; // a curve needs no room for a scale of colours

  function curve(xs, here, finite) {
    if (!finite.length) {
      drawing.append(make("text", { x: width / 2, y: height / 2, "text-anchor": "middle" }, ["infinite everywhere"]));
      return;
    }
    const low = Math.min(...finite), high = Math.max(...finite), log = low > 0 && high / low > 30;
    const y = (v) => (log ? Math.log10(v) : v), pad = (y(high) - y(low) || Math.abs(y(low)) || 1) * 0.05;
    const limits = [y(low) - pad, y(high) + pad], x = axisOf(map.x);
    const axes = frame({ ...box, width: wide() }, { ...x, low: xs[0], high: xs[xs.length - 1], ticks: x.ticks.filter((t) => t >= xs[0] && t <= xs[xs.length - 1]) },
      { low: limits[0], high: limits[1], label: nice(map),
        ticks: log ? logTicks(low, high).map(Math.log10) : ticks(limits[0], limits[1], 6), show: log ? (v) => pretty(10 ** v, 3) : null });
    let path = "", pen = false;
    xs.forEach((v, i) => {
      const fine = Number.isFinite(here[i]) && (!log || here[i] > 0);
      if (fine) path += `${pen ? "L" : "M"}${axes.px(v).toFixed(2)} ${axes.py(y(here[i])).toFixed(2)}`;
      pen = fine;
    });
    drawing.append(axes.group, make("path", { d: path, class: "ellipse c0" }));
    if (cursor) drawing.append(make("path", { d: `M${axes.px(xs[cursor[0]])} ${box.top}v${box.height}`, class: "cursor" }));
    shown.axes = axes;
  }

  function readout() {
    if (!cursor) { words.textContent = "Point at the drawing, or focus it and use the arrow keys, to read values."; return; }
    const [i, j] = cursor, axis = (a, k) => `${plain(data.axes[a].name)} ${pretty(data.axes[a].values[k], 6)}${unitText(data.axes[a].unit)}`;
    const v = shown.here[j * shown.xs.length + i];
    words.textContent = `${axis(map.x, i)}${map.y === null ? "" : `, ${axis(map.y, j)}`}: ${pretty(v, 3)} ${unitText(map.unit)}`;
  }

  const nearest = (list, v) => list.reduce((best, x, i) => (Math.abs(x - v) < Math.abs(list[best] - v) ? i : best), 0);
  drawing.addEventListener("pointermove", (event) => {
    const area = drawing.getBoundingClientRect(), line = map.y === null, breadth = line ? wide() : box.width;
    const u = (((event.clientX - area.left) / area.width) * width - box.left) / breadth; // 0 ... 1 within the frame
    const v = (((event.clientY - area.top) / area.height) * height - box.top) / box.height;
    if (u < 0 || u > 1 || v < 0 || v > 1) return;
    const x = axisOf(map.x), y = line ? null : axisOf(map.y);
    if (line) [x.low, x.high] = [shown.xs[0], shown.xs[shown.xs.length - 1]];
    const at = (axis, part, list) => nearest(list.map(axis.of), axis.of(axis.low) + part * (axis.of(axis.high) - axis.of(axis.low)));
    cursor = [at(x, u, shown.xs), line ? 0 : at(y, 1 - v, shown.ys)];
    readout();
  });
  drawing.addEventListener("keydown", (event) => {
    const move = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] }[event.key];
    if (!move) return;
    event.preventDefault();
    cursor = cursor || [Math.floor(shown.xs.length / 2), Math.floor(shown.ys.length / 2)];
    const within = (i, list) => Math.min(list.length - 1, Math.max(0, i));
    cursor = [within(cursor[0] + move[0], shown.xs), within(cursor[1] + move[1], shown.ys)];
    draw();
  });
  remake();
  const csv = () => {
    const x = data.axes[map.x], y = map.y === null ? null : data.axes[map.y];
    const fixed = others.map((o) => [data.axes[o.axis].name, data.axes[o.axis].values[o.choice.get()]]);
    const head = [x.name, ...(y ? [y.name] : []), ...fixed.map((f) => f[0]), map.name];
    return [head, ...shown.ys.flatMap((b, j) => shown.xs.map((a, i) => [a, ...(y ? [b] : []), ...fixed.map((f) => f[1]), Number(shown.here[j * shown.xs.length + i].toPrecision(4))]))];
  };
  place.append(savers(place.id, { svg: () => drawing, csv }));
}
