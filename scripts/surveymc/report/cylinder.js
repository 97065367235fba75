// The travelling cylinder: where the other wells are, seen along the reference, with rings of distance.
function cylinderExplorer(place, data, state) {
  const keep = state.kept;
  const which = keep("point", choice(data.key || "point", data.scenes.map((s) => s.label), remake));
  const scale = keep("rings", choice("rings", ["equal steps", "logarithmic"], draw));
  const reach = make("input", { type: "range", min: 0, max: 100, "aria-label": "How far out" }, [], true), said = make("output", {}, [], true);
  reach.addEventListener("input", draw);
  const width = Math.max(290, Math.min(660, place.clientWidth)), height = width;
  const drawing = make("svg", { viewBox: `0 0 ${width} ${height}`, width, height, role: "img", class: "cylinder" });
  const legend = make("fieldset", { class: "legend" }, [], true), words = make("p", { class: "readout", "aria-live": "polite" }, [], true);
  place.append(make("div", { class: "controls" }, [...(data.scenes.length > 1 ? [which.element] : []), scale.element,
    make("label", { class: "choice" }, ["out to", reach, said], true)], true), legend, drawing, words);
  const LINES = ["c1", "c4", "c3", "c5", "c7", "c2", "c6", "c0"], cx = width / 2, cy = height / 2, most = width / 2 - 34;
  let scene, boxes, dots = [];

  function remake() {
    scene = data.scenes[which.get()];
    boxes = scene.offsets.map((o, i) => {
      const box = check(o.name, true, draw);
      box.element.append(" ", make("svg", { class: "sample", viewBox: "0 0 34 8", "aria-hidden": "true" }, [make("line", { x1: 1, x2: 33, y1: 4, y2: 4, class: LINES[i % 8] })]));
      return box;
    });
    legend.replaceChildren(make("legend", {}, ["Offsets"], true), ...boxes.map((b) => b.element));
    // what matters is near: at first, out to twice of how near an offset may come, or to the nearest one
    const all = scene.offsets.flatMap((o) => o.distance.filter((d) => d > 0)), limits = scene.offsets.flatMap((o) => o.limit.filter(Number.isFinite));
    const least = Math.min(...all), farthest = Math.max(...all), wanted = Math.max(2.2 * Math.max(0, ...limits), 1.5 * least);
    reach.value = farthest > least ? Math.round((100 * Math.log(Math.min(1, wanted / farthest) * (farthest / least))) / Math.log(farthest / least)) : 100;
    draw();
  }

  function draw() {
    const shown = scene.offsets.filter((_, i) => boxes[i].get());
    const all = shown.flatMap((o) => o.distance.filter((d, i) => d > 0 && Number.isFinite(o.toolface[i])));
    if (!all.length) {
      drawing.replaceChildren(make("text", { x: cx, y: cy, "text-anchor": "middle" }, ["no offset here"]));
      return;
    }
    let least = Infinity, farthest = 0;
    for (const d of all) { least = Math.min(least, d); farthest = Math.max(farthest, d); }
    const log = scale.get() === 1, inner = log ? least / 1.5 : 0;
    // the slider goes from the nearest point to the farthest one, by ratios: what matters is near
    const outer = 1.08 * least * (farthest / least) ** (reach.value / 100);
    said.textContent = `${pretty(outer, 3)} m`;
    const r = (d) => (log ? Math.max(0, Math.log(d / inner) / Math.log(outer / inner)) : d / outer) * most;
    const place2 = (d, angle) => [cx + r(d) * Math.sin((angle * Math.PI) / 180), cy - r(d) * Math.cos((angle * Math.PI) / 180)];
    const group = make("g", { class: "axes" });
    const rings = log ? logTicks(inner, outer) : ticks(0, outer, 4).filter((t) => t > 0);
    for (let a = 0; a < 360; a += 30) {
      const [x, y] = [cx + most * Math.sin((a * Math.PI) / 180), cy - most * Math.cos((a * Math.PI) / 180)];
      group.append(make("line", { x1: cx, y1: cy, x2: x, y2: y, class: "grid" }));
      group.append(make("text", { x: cx + (most + 17) * Math.sin((a * Math.PI) / 180), y: cy - (most + 17) * Math.cos((a * Math.PI) / 180) + 4, "text-anchor": "middle" }, [`${a}°`]));
    }
    for (const d of rings) {
      group.append(make("circle", { cx, cy, r: r(d), class: "frame ring" }));
    }
    group.append(make("circle", { cx, cy, r: most, class: "frame" }), make("circle", { cx, cy, r: 2.5, class: "centre" }));
    const parts = [make("title", {}, ["Travelling cylinder"]), group];
    dots = [];
    scene.offsets.forEach((o, i) => {
      if (!boxes[i].get()) return;
      const look = LINES[i % 8], fine = (j) => Number.isFinite(o.toolface[j]) && o.distance[j] > 0 && o.distance[j] <= outer;
      let path = "", limit = "", pen = false;
      o.md.forEach((m, j) => {
        if (!fine(j)) { pen = false; return; }
        const [x, y] = place2(o.distance[j], o.toolface[j]);
        path += `${pen ? "L" : "M"}${x.toFixed(1)} ${y.toFixed(1)}`;
        pen = true;
        dots.push({ x, y, o, j });
      });
      pen = false;
      o.md.forEach((m, j) => { // how near the offset may come in its direction
        if (!fine(j) || !(o.limit[j] > 0 && o.limit[j] <= outer)) { pen = false; return; }
        const [x, y] = place2(Math.max(o.limit[j], inner), o.toolface[j]);
        limit += `${pen ? "L" : "M"}${x.toFixed(1)} ${y.toFixed(1)}`;
        pen = true;
      });
      parts.push(make("path", { d: limit, class: `ellipse thin ${look}`, "stroke-dasharray": "3 3" }), make("path", { d: path, class: `ellipse ${look}` }));
      const here = dots.filter((d) => d.o === o);
      here.forEach((d) => {
        const broken = o.factor[d.j] < 1;
        parts.push(make("circle", { cx: d.x.toFixed(1), cy: d.y.toFixed(1), r: broken ? 4.5 : 2.2, class: broken ? `broken ${look}` : `point ${look}` }));
      });
      const every = Math.max(1, Math.ceil(here.length / 5));
      let last = null;
      here.forEach((d, n) => {
        if ((n % every && n !== here.length - 1) || (last && Math.hypot(last.x - d.x, last.y - d.y) < 34)) return;
        last = d;
        parts.push(make("text", { x: d.x + 7, y: d.y - 5, class: "depth" }, [`${pretty(o.md[d.j], 5)}`]));
      });
    });
    // the rings' labels stand where the fewest points are
    const crowd = (a) => dots.filter((d) => Math.abs(((Math.atan2(d.x - cx, cy - d.y) * 180) / Math.PI - a + 540) % 360 - 180) < 20).length;
    const free = [45, 75, 105, 135, 165, 195, 225, 255, 285, 315, 345, 15].reduce((a, b) => (crowd(b) < crowd(a) ? b : a));
    for (const d of rings) {
      const [x, y] = place2(d, free);
      parts.push(make("text", { x, y: y + 4, "text-anchor": "middle", class: "ringlabel" }, [`${pretty(d, 3)} m`]));
    }
    drawing.replaceChildren(...parts);
    words.textContent = "High side of the reference is up. Solid: the offset, numbers are measured depths of the reference (m). Dashed: how near it may come (separation factor 1). Large rings: nearer than that.";
  }

  drawing.addEventListener("pointermove", (event) => {
    const area = drawing.getBoundingClientRect(), x = ((event.clientX - area.left) * width) / area.width, y = ((event.clientY - area.top) * height) / area.height;
    const best = dots.reduce((a, d) => (!a || Math.hypot(d.x - x, d.y - y) < Math.hypot(a.x - x, a.y - y) ? d : a), null);
    if (!best || Math.hypot(best.x - x, best.y - y) > 20) return;
    const { o, j } = best;
    words.textContent = `${o.name}: measured depth ${pretty(o.md[j], 5)} m of the reference, ${pretty(o.offset_md[j], 5)} m of the offset; distance ${pretty(o.distance[j], 4)} m at ${pretty(o.toolface[j], 4)}° from the high side; separation factor ${pretty(o.factor[j], 3)}`;
  });
  remake();
  const csv = () => [["offset", "md_m", "offset_md_m", "distance_m", "toolface_deg", "distance_at_factor_1_m", "separation_factor"],
    ...scene.offsets.flatMap((o) => o.md.map((m, j) => [o.name, m, o.offset_md[j], o.distance[j], o.toolface[j], o.limit[j], o.factor[j]]))];
  place.append(savers(place.id, { svg: () => drawing, csv }));
}
