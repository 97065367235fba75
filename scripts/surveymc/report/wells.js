// Wells with their ellipsoids in space, to turn and to zoom: three.js (THREE) draws them, the words are text of the page.
const WELL_COLOURS = ["--c0", "--c1", "--c4", "--c3", "--c5", "--c7", "--c2", "--c6"];

function wellsExplorer(place, data, state) {
  const variable = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();
  const keep = state.kept;
  const labels = data.scenes.map((s) => s.label);
  const which = keep("point", choice(data.key || "point", labels, () => remake()));
  const size = keep("sigma", choice("ellipsoids", ["1σ", "2σ", "3σ"], () => restyle(), 1));
  const FACTORS = [1, 2, 5, 10, 20, 50, 100, 200, 500, 1000];
  const factor = keep("times", choice("enlarged", FACTORS.map((f) => (f === 1 ? "not" : `${f} times`)), () => restyle(), 0));
  const views = ["from the side", "from above", "from the south", "from the east"];
  const view = choice("look", views, () => look());
  const button = (text, label, act) => {
    const b = make("button", { type: "button", "aria-label": label }, [text], true);
    b.addEventListener("click", act);
    return b;
  };
  const goto = make("span", { class: "choice" }, [], true), shown = make("fieldset", { class: "legend" }, [], true);
  const stage = make("div", { class: "stage", tabindex: 0, role: "img", "aria-label": "Wells in space. Drag to turn, keys + and − to zoom, arrow keys to move." }, [], true);
  const over = make("div", { class: "marks3", "aria-hidden": "true" }, [], true), tip = make("p", { class: "readout", "aria-live": "polite" }, [], true);
  stage.append(over);
  place.append(make("div", { class: "controls" }, [...(labels.length > 1 ? [which.element] : []), size.element, factor.element, view.element, goto,
    make("span", { class: "choice" }, [button("+", "Nearer", () => zoom(0.7)), button("−", "Farther", () => zoom(1 / 0.7)),
      button("whole", "The whole", () => { target.value = "0"; look(); })], true)], true), shown, stage, tip);
  const help = "Drag to turn, with the right button or two fingers to move; the wheel zooms once the drawing has been clicked. Point at a well to read it.";
  tip.textContent = help;

  const space = new THREE.Scene(), camera = new THREE.PerspectiveCamera(32, 1, 1e-4, 1e3);
  space.add(new THREE.AmbientLight(0xffffff, 0.62));
  const lamp = new THREE.DirectionalLight(0xffffff, 0.5);
  space.add(lamp);
  const controls = new THREE.OrbitControls(camera, stage);
  controls.enableZoom = false; // the wheel scrolls the page, until the drawing has the focus
  controls.enableKeys = false;
  controls.screenSpacePanning = true;
  stage.addEventListener("focus", () => { controls.enableZoom = true; });
  stage.addEventListener("blur", () => { controls.enableZoom = false; });
  stage.addEventListener("pointerdown", () => stage.focus({ preventScroll: true }));

  let renderer = null, scene, middle, unit, objects = null, materials = [], target, marks = [], boxes = [], spots = [];
  /** (north, east, down) in metres -> the drawing: x east, y up, z south; the largest side of the box is 2. */
  const at = (n, e, v) => new THREE.Vector3((e - middle[1]) / unit, -(v - middle[2]) / unit, -(n - middle[0]) / unit);

  function remake() {
    scene = data.scenes[which.get()];
    const low = [Infinity, Infinity, Infinity], high = [-Infinity, -Infinity, -Infinity];
    for (const w of scene.wells) for (let i = 0; i < w.md.length; ++i) [w.north[i], w.east[i], w.down[i]].forEach((x, k) => { low[k] = Math.min(low[k], x); high[k] = Math.max(high[k], x); });
    const longest = Math.max(...high.map((h, k) => h - low[k])) || 1;
    for (let k = 0; k < 3; ++k) { // a well along one axis has a box with some width
      const room = Math.max(0.04 * longest, 0.16 * longest - (high[k] - low[k]) / 2);
      low[k] -= room;
      high[k] += room;
    }
    middle = low.map((l, k) => (l + high[k]) / 2);
    unit = Math.max(...high.map((h, k) => h - low[k])) / 2;
    scene.low = low;
    scene.high = high;
    const largest = Math.max(0, ...scene.ellipsoids.map((e) => Math.max(...e.axes.map((a) => Math.hypot(...a)))));
    if (!factor.touched && !factor.given) { // the largest whole step with which they stay smaller than a twelfth of the drawing
      const fitting = FACTORS.filter((f) => 2 * f * largest <= unit / 6);
      factor.set(fitting.length && largest > 0 ? FACTORS.indexOf(fitting[fitting.length - 1]) : 0);
    }
    boxes = scene.wells.map((w, i) => {
      const box = check(w.name, true, restyle);
      box.element.append(" ", make("svg", { class: "sample", viewBox: "0 0 34 8", "aria-hidden": "true" }, [
        make("line", { x1: 1, x2: 33, y1: 4, y2: 4, style: `--c: var(${WELL_COLOURS[i % WELL_COLOURS.length]})` })]));
      return box;
    });
    shown.replaceChildren(make("legend", {}, ["Wells"], true), ...boxes.map((b) => b.element));
    spots = [{ label: "the whole", centre: null },
      ...scene.ellipsoids.map((e) => ({ label: `${scene.wells[e.well].name}, ${e.label}`, centre: e.centre, reach: Math.max(...e.axes.map((a) => Math.hypot(...a))) }))];
    target = make("select", { "aria-label": "go to" }, spots.map((s, i) => make("option", { value: i }, [s.label], true)), true);
    target.addEventListener("change", look);
    goto.replaceChildren(make("label", {}, ["go to"], true), target);
    restyle();
    look();
  }

  function line(points, colour, width, dashed) {
    const geometry = new THREE.LineGeometry();
    geometry.setPositions(points.flatMap((p) => [p.x, p.y, p.z]));
    const material = new THREE.LineMaterial({ color: new THREE.Color(colour), linewidth: width, transparent: Boolean(dashed), opacity: dashed ? 0.5 : 1 });
    materials.push(material);
    return new THREE.Line2(geometry, material);
  }

  /** All objects anew: sizes, colours of the theme, wells that are shown. */
  function restyle() {
    if (objects) {
      space.remove(objects);
      objects.traverse((o) => { if (o.geometry) o.geometry.dispose(); if (o.material) o.material.dispose(); });
    }
    objects = new THREE.Group();
    materials = [];
    marks = [];
    const colour = (i) => variable(WELL_COLOURS[i % WELL_COLOURS.length]), k = (size.get() + 1) * FACTORS[factor.get()];
    scene.wells.forEach((w, i) => {
      if (!boxes[i].get()) return;
      const points = w.md.map((_, j) => at(w.north[j], w.east[j], w.down[j]));
      objects.add(line(points, colour(i), 3));
      marks.push(...points.map((p, j) => ({ at: p, text: `${w.name}: measured depth ${pretty(w.md[j], 6)} m, north ${pretty(w.north[j], 6)} m, east ${pretty(w.east[j], 6)} m, down ${pretty(w.down[j], 6)} m` })));
    });
    const ball = new THREE.SphereBufferGeometry(1, 32, 20);
    for (const e of scene.ellipsoids) {
      if (!boxes[e.well].get()) continue;
      // in the drawing a semi-axis is a vector; one that is nothing gets a millionth of the largest, so that normals are defined
      const most = Math.max(...e.axes.map((a) => Math.hypot(...a)));
      const axes = e.axes.map(([n, a, v]) => new THREE.Vector3(a, -v, -n).multiplyScalar(k / unit));
      axes.forEach((a, j) => { if (a.length() < 1e-5 * k * most / unit) a.copy(axes[(j + 1) % 3]).cross(axes[(j + 2) % 3]).setLength(1e-5 * k * most / unit); });
      const c = at(...e.centre), m = new THREE.Matrix4().makeBasis(...axes).setPosition(c);
      if (m.determinant() < 0) m.makeBasis(axes[0], axes[1], axes[2].clone().negate()).setPosition(c);
      const mesh = new THREE.Mesh(ball.clone().applyMatrix(m), new THREE.MeshLambertMaterial({ color: new THREE.Color(colour(e.well)), transparent: true, opacity: 0.42, depthWrite: false }));
      objects.add(mesh);
      for (const [a, b] of [[0, 1], [1, 2], [0, 2]]) { // its principal sections, by which the eye sees the shape
        const ring = [];
        for (let i = 0; i <= 72; ++i) ring.push(c.clone().addScaledVector(axes[a], Math.cos((i * Math.PI) / 36)).addScaledVector(axes[b], Math.sin((i * Math.PI) / 36)));
        objects.add(line(ring, colour(e.well), 1.2));
      }
      const sigma = size.get() + 1;
      marks.push({ at: c, near: true, text: `${scene.wells[e.well].name}, ${e.label}: ${sigma}σ semi-axes ${e.axes.map((a) => pretty(sigma * Math.hypot(...a), 3)).join(", ")} m` });
    }
    const [n0, e0, v0] = scene.low, [n1, e1, v1] = scene.high, soft = variable("--line");
    const corner = (n, e, v) => at(n ? n1 : n0, e ? e1 : e0, v ? v1 : v0);
    for (const [a, b] of [[0, 1], [0, 2], [0, 4], [1, 3], [1, 5], [2, 3], [2, 6], [3, 7], [4, 5], [4, 6], [5, 7], [6, 7]]) {
      objects.add(line([corner(a & 1, a & 2, a & 4), corner(b & 1, b & 2, b & 4)], soft, 1));
    }
    for (const t of ticks(n0, n1, 5)) objects.add(line([at(t, e0, v1), at(t, e1, v1)], soft, 1, true));
    for (const t of ticks(e0, e1, 5)) objects.add(line([at(n0, t, v1), at(n1, t, v1)], soft, 1, true));
    space.add(objects);
    draw();
  }

  /** The camera: from where `view` says, at what `go to` says. */
  function look() {
    const spot = spots[Number(target.value)], from = [[0.75, 0.45, 1], [0, 1, 1e-4], [0, 0, 1], [1, 0, 0]][view.get()];
    const centre = spot.centre ? at(...spot.centre) : new THREE.Vector3(0, 0, 0);
    const sides = scene.high.map((h, k) => (h - scene.low[k]) / 2 / unit), k = (size.get() + 1) * FACTORS[factor.get()];
    const reach = spot.centre ? Math.max(3.2 * k * spot.reach / unit, 1e-5) : Math.hypot(...sides) * 1.04;
    camera.aspect = (stage.clientWidth || 4) / (stage.clientHeight || 3);
    const narrow = Math.min(1, camera.aspect);
    controls.target.copy(centre);
    camera.position.copy(centre).addScaledVector(new THREE.Vector3(...from).normalize(), reach / Math.sin((camera.fov * Math.PI) / 360) / narrow);
    controls.update();
    draw();
  }

  function zoom(by) {
    camera.position.sub(controls.target).multiplyScalar(by).add(controls.target);
    controls.update();
    draw();
  }

  let waiting = false;
  function draw() {
    if (waiting) return;
    waiting = true;
    requestAnimationFrame(() => { waiting = false; paint(); });
  }

  function paint() {
    const width = stage.clientWidth, height = stage.clientHeight;
    if (!width || !scene || !renderer) return;
    renderer.setPixelRatio(Math.min(2, devicePixelRatio || 1));
    renderer.setSize(width, height);
    camera.aspect = width / height;
    const distance = camera.position.distanceTo(controls.target);
    camera.near = Math.max(1e-6, distance / 500);
    camera.far = distance + 20;
    camera.updateProjectionMatrix();
    lamp.position.copy(camera.position).add(new THREE.Vector3(0.3, 0.8, 0.2));
    for (const m of materials) m.resolution.set(width, height);
    renderer.render(space, camera);
    write(width, height);
    place.dataset.drawn = String(Number(place.dataset.drawn || 0) + 1);
  }

  const seen = (p, width, height) => {
    const q = p.clone().project(camera);
    return { x: ((q.x + 1) / 2) * width, y: ((1 - q.y) / 2) * height, front: q.z > -1 && q.z < 1 };
  };

  /** Names and ticks of the three axes, at the edges of the box that are free of the drawing. */
  function write(width, height) {
    const [n0, e0, v0] = scene.low, [n1, e1, v1] = scene.high, found = [], c = camera.position;
    const south = c.z > 0, east = c.x > 0; // the sides that the camera is at
    const up = c.clone().sub(controls.target).normalize().y > 0.995;
    const nearN = south ? n0 : n1, nearE = east ? e1 : e0;
    const heart = seen(at(middle[0], middle[1], middle[2]), width, height);
    const axis = (name, list, point, end) => {
      const first = seen(point(end[0]), width, height), last = seen(point(end[1]), width, height);
      const long = Math.hypot(first.x - last.x, first.y - last.y);
      if (long < 24) return;
      // words stand off the edge, away from the drawing
      let out = { x: (last.y - first.y) / long, y: (first.x - last.x) / long };
      const mid = { x: (first.x + last.x) / 2, y: (first.y + last.y) / 2 };
      if (out.x * (mid.x - heart.x) + out.y * (mid.y - heart.y) < 0) out = { x: -out.x, y: -out.y };
      const steep = Math.abs(first.x - last.x) < 0.5 * Math.abs(first.y - last.y), near = steep ? 24 : 15, far = steep ? 56 : 38;
      const step = Math.ceil((list.length * (steep ? 22 : 42)) / long);
      list.filter((_, i) => i % step === 0).forEach((t) => {
        const s = seen(point(t), width, height);
        found.push({ x: s.x + near * out.x, y: s.y + near * out.y, front: s.front, text: pretty(t, 6) });
      });
      found.push({ x: mid.x + far * out.x, y: mid.y + far * out.y, front: first.front && last.front, text: name, name: true, rotate: steep });
    };
    axis("north (m)", ticks(n0, n1, 5), (t) => at(t, nearE, v1), [n0, n1]);
    axis("east (m)", ticks(e0, e1, 5), (t) => at(nearN, t, v1), [e0, e1]);
    if (!up) { // the vertical edge that is the leftmost one
      const edges = [[n0, e0], [n0, e1], [n1, e0], [n1, e1]].map(([n, e]) => ({ n, e, x: seen(at(n, e, (v0 + v1) / 2), width, height).x }));
      const left = edges.reduce((a, b) => (b.x < a.x ? b : a));
      axis("down (m)", ticks(v0, v1, 6), (t) => at(left.n, left.e, t), [v0, v1]);
    }
    over.replaceChildren(...found.filter((f) => f.front && f.x > -40 && f.y > -20 && f.x < width + 40 && f.y < height + 20).map((f) => {
      const [wide, high] = f.rotate ? [9, 34] : [6 + 3.4 * f.text.length, 9]; // half of its size, so that nothing is cut
      const x = Math.min(width - wide, Math.max(wide, f.x)), y = Math.min(height - high, Math.max(high, f.y));
      return make("span", { class: `${f.name ? "name" : "tick"}${f.rotate ? " rotate" : ""}`, style: `left:${x.toFixed(1)}px;top:${y.toFixed(1)}px` }, [f.text], true);
    }));
  }

  controls.addEventListener("change", draw);
  stage.addEventListener("pointermove", (event) => {
    if (event.buttons) return;
    const area = stage.getBoundingClientRect(), x = event.clientX - area.left, y = event.clientY - area.top;
    let best = null, least = 14;
    for (const m of marks) {
      const s = seen(m.at, area.width, area.height), d = Math.hypot(s.x - x, s.y - y) - (m.near ? 3 : 0);
      if (s.front && d < least) { least = d; best = m; }
    }
    tip.textContent = best ? best.text : help;
  });
  stage.addEventListener("keydown", (event) => {
    const turn = { ArrowLeft: [-0.15, 0], ArrowRight: [0.15, 0], ArrowUp: [0, -0.1], ArrowDown: [0, 0.1] }[event.key];
    if (event.key === "+" || event.key === "=") zoom(0.8);
    else if (event.key === "-") zoom(1.25);
    else if (turn) {
      const s = new THREE.Spherical().setFromVector3(camera.position.clone().sub(controls.target));
      s.theta += turn[0];
      s.phi = Math.min(Math.PI - 0.01, Math.max(0.01, s.phi + turn[1]));
      camera.position.setFromSpherical(s).add(controls.target);
      controls.update();
      draw();
    } else return;
    event.preventDefault();
  });
  document.addEventListener("themechange", restyle);
  remake();
  // A browser draws in space at some places only at a time: this one begins when it is near.
  const near = new IntersectionObserver((entries) => {
    if (!entries.some((e) => e.isIntersecting)) return;
    near.disconnect();
    try {
      renderer = new THREE.WebGLRenderer({ antialias: true, alpha: true, preserveDrawingBuffer: true });
    } catch {
      stage.classList.add("without");
      tip.textContent = "This browser draws nothing in space (no WebGL). The figures and tables have the same numbers.";
      return;
    }
    stage.prepend(renderer.domElement);
    new ResizeObserver(draw).observe(stage);
    look();
  }, { rootMargin: "300px" });
  near.observe(stage);
  const csv = () => [["kind", "well", "md_m", "north_m", "east_m", "down_m", "axis1_north_m", "axis1_east_m", "axis1_down_m", "axis2_north_m", "axis2_east_m", "axis2_down_m", "axis3_north_m", "axis3_east_m", "axis3_down_m"],
    ...scene.wells.flatMap((w) => w.md.map((m, j) => ["station", w.name, m, w.north[j], w.east[j], w.down[j]])),
    ...scene.ellipsoids.map((e) => ["ellipsoid, 1 sigma", scene.wells[e.well].name, e.md, ...e.centre, ...e.axes.flat()])];
  place.append(savers(place.id, { png: () => { if (!renderer) look(); paint(); return overlaid(renderer.domElement, over, stage); }, csv }));
}

/** The drawing in space with the words over it, on the paper of the page, as a canvas. */
function overlaid(canvas, words, stage) {
  const whole = document.createElement("canvas"), paint = whole.getContext("2d"), scale = canvas.width / stage.clientWidth;
  whole.width = canvas.width;
  whole.height = canvas.height;
  paint.fillStyle = getComputedStyle(document.body).backgroundColor;
  paint.fillRect(0, 0, whole.width, whole.height);
  paint.drawImage(canvas, 0, 0);
  const area = stage.getBoundingClientRect();
  for (const span of words.children) {
    const box = span.getBoundingClientRect(), style = getComputedStyle(span);
    paint.save();
    paint.translate(((box.left + box.right) / 2 - area.left) * scale, ((box.top + box.bottom) / 2 - area.top) * scale);
    if (span.classList.contains("rotate")) paint.rotate(-Math.PI / 2);
    paint.font = `${parseFloat(style.fontSize) * scale}px ${style.fontFamily}`;
    paint.fillStyle = style.color;
    paint.textAlign = "center";
    paint.textBaseline = "middle";
    paint.fillText(span.textContent, 0, 0);
    paint.restore();
  }
  return whole;
}
