// What the drawings share: elements, number formats, axes, choices, what is saved. No library, no network.
"use strict";
const SVG = "http://www.w3.org/2000/svg";

/** An SVG (or, with html = true, HTML) element with attributes and children. */
function make(name, attributes, children, html) {
  const element = html ? document.createElement(name) : document.createElementNS(SVG, name);
  for (const key in attributes || {}) element.setAttribute(key, attributes[key]);
  for (const child of children || []) element.append(child);
  return element;
}

/** A number for people: `digits` significant digits, and no exponent between 1e-4 and 1e6. */
function pretty(value, digits) {
  if (Number.isNaN(value)) return "–";
  if (!Number.isFinite(value)) return value > 0 ? "∞" : "−∞";
  if (value === 0) return "0";
  const size = Math.abs(value);
  const text = size >= 1e-4 && size < 1e6 ? String(Number(value.toPrecision(digits))) : Number(value.toPrecision(digits)).toExponential();
  return text.replace(/-/g, "−");
}

/** A name of a result file as it is printed: the unit stands beside it. */
function plain(name) {
  return name.replace(/_(deg|nT|mps2|m)$/, "").replace(/_/g, " ");
}

/** Units as they are printed. */
function unitText(unit) {
  return { deg: "°", mps2: "m/s²", "1": "" }[unit] ?? unit;
}

/** About `count` round numbers from low to high. */
function ticks(low, high, count) {
  const rough = (high - low) / count, power = 10 ** Math.floor(Math.log10(rough));
  const step = [1, 2, 2.5, 5, 10].map((s) => s * power).find((s) => s >= rough * 0.999) || 10 * power;
  const found = [];
  for (let k = Math.ceil(low / step - 1e-9); k * step <= high + 1e-9 * step; ++k) found.push(Number((k * step).toPrecision(12)));
  return found;
}

/** Ticks of an axis of angles come at 15, 30, 45, 90 degrees. */
function angleTicks(low, high, count) {
  const step = [1, 2, 5, 10, 15, 30, 45, 90, 180].find((s) => (high - low) / s <= count) || 360;
  const found = [];
  for (let k = Math.ceil(low / step); k * step <= high; ++k) found.push(k * step);
  return found;
}

/** The frame of a plot with ticks and labels. box: left, top, width, height; x, y: { low, high, label, ticks, show, of }; of: what is
 *  linear along the axis (Math.log10 for a logarithmic one). */
function frame(box, x, y) {
  const group = make("g", { class: "axes" });
  const part = (axis) => {
    const of = axis.of || ((v) => v), low = of(axis.low), high = of(axis.high);
    return (v) => (of(v) - low) / (high - low);
  };
  const along = part(x), up = part(y);
  const px = (v) => box.left + along(v) * box.width, py = (v) => box.top + box.height - up(v) * box.height;
  for (const t of x.ticks) {
    group.append(make("line", { x1: px(t), x2: px(t), y1: box.top, y2: box.top + box.height, class: "grid" }));
    group.append(make("text", { x: px(t), y: box.top + box.height + 18, "text-anchor": "middle" }, [pretty(t, 6)]));
  }
  for (const t of y.ticks) {
    group.append(make("line", { x1: box.left, x2: box.left + box.width, y1: py(t), y2: py(t), class: "grid" }));
    group.append(make("text", { x: box.left - 7, y: py(t) + 4, "text-anchor": "end" }, [y.show ? y.show(t) : pretty(t, 6)]));
  }
  group.append(make("rect", { x: box.left, y: box.top, width: box.width, height: box.height, class: "frame" }));
  group.append(make("text", { x: box.left + box.width / 2, y: box.top + box.height + 40, "text-anchor": "middle", class: "label" }, [x.label]));
  const middle = box.top + box.height / 2;
  group.append(make("text", { x: 16, y: middle, "text-anchor": "middle", class: "label", transform: `rotate(-90 16 ${middle})` }, [y.label]));
  return { group, px, py };
}

/** Round numbers between two positive ones, for a logarithmic axis. */
function logTicks(low, high) {
  const decades = Math.log10(high / low), steps = decades > 3 ? [1] : decades > 1.5 ? [1, 3] : [1, 2, 5], found = [];
  for (let e = Math.floor(Math.log10(low)); e <= Math.log10(high); ++e) found.push(...steps.map((s) => s * 10 ** e));
  return found.filter((v) => v >= low && v <= high);
}

let controls = 0;
/** A labelled choice; `changed` is called after each change. values: texts. A long list of numbers becomes a slider. */
function choice(label, values, changed, start = 0) {
  const id = `choice-${++controls}`, is = values.length > 30 ? "slider" : "list";
  const name = make("label", { for: id }, [label], true), whole = make("span", { class: "choice" }, [name], true);
  const chosen = { element: whole, texts: values, touched: false, given: false, get: () => Number(chosen.input.value) };
  if (is === "slider") {
    const shown = make("output", { for: id }, [values[start]], true);
    chosen.input = make("input", { id, type: "range", min: 0, max: values.length - 1, step: 1 }, [], true);
    chosen.show = () => {
      shown.textContent = values[chosen.input.value];
      chosen.input.setAttribute("aria-valuetext", values[chosen.input.value]);
    };
    whole.append(chosen.input, shown);
  } else {
    chosen.input = make("select", { id }, values.map((v, i) => make("option", { value: i }, [v], true)), true);
    chosen.show = () => {};
    whole.append(chosen.input);
  }
  chosen.set = (i) => { chosen.input.value = i; chosen.show(); };
  chosen.set(start);
  chosen.input.addEventListener(is === "slider" ? "input" : "change", () => { chosen.touched = true; chosen.show(); changed(); });
  return chosen;
}

/** What a drawing shows, in the address of the page: "#ID;map=azimuth sd;inclination=30". A link to it shows the same. */
function stateOf(id) {
  const now = new Map(), asked = new Map();
  const [place, ...parts] = location.hash.slice(1).split(";");
  if (place === id) for (const part of parts) {
    const [key, ...value] = part.split("=");
    try { asked.set(decodeURIComponent(key), decodeURIComponent(value.join("="))); } catch { /* a broken address asks for nothing */ }
  }
  const write = () => {
    const words = [...now].map(([key, chosen]) => `;${encodeURIComponent(key)}=${encodeURIComponent(chosen.texts[chosen.get()])}`);
    history.replaceState(null, "", `#${id}${words.join("")}`);
  };
  return {
    /** Keeps a choice in the address under this name, and sets it to what the address asks for. */
    kept(key, chosen) {
      now.set(key, chosen);
      chosen.input.addEventListener("change", write);
      const wanted = chosen.texts.indexOf(asked.get(key));
      asked.delete(key);
      if (wanted >= 0) {
        chosen.set(wanted);
        chosen.given = true;
      }
      return chosen;
    },
    forget(keep) { for (const key of [...now.keys()]) if (!keep.includes(key)) now.delete(key); },
  };
}

/** Gives the reader a file. */
function download(name, data, type) {
  const link = make("a", { href: URL.createObjectURL(new Blob([data], { type })), download: name }, [], true);
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10000);
}

const LOOK = ["fill", "fill-opacity", "stroke", "stroke-width", "stroke-dasharray", "opacity", "font-size", "font-family", "font-weight", "text-anchor", "image-rendering", "paint-order"];
/** An SVG of the page as a file of its own: with its colours, on the paper of the page. */
function svgText(svg) {
  const copy = svg.cloneNode(true), from = [svg, ...svg.querySelectorAll("*")], to = [copy, ...copy.querySelectorAll("*")];
  from.forEach((element, i) => {
    const style = getComputedStyle(element);
    to[i].setAttribute("style", LOOK.map((key) => `${key}:${style.getPropertyValue(key).replace(/"/g, "'")}`).join(";"));
    to[i].removeAttribute("class");
  });
  const [, , width, height] = svg.getAttribute("viewBox").split(" ");
  copy.setAttribute("width", width);
  copy.setAttribute("height", height);
  copy.prepend(make("rect", { width, height, fill: getComputedStyle(document.body).backgroundColor }));
  return new XMLSerializer().serializeToString(copy);
}

/** A picture of this address, drawn twice as large as it is shown, as a canvas. */
async function canvasOf(address, width, height) {
  const picture = new Image(width, height);
  picture.src = address;
  await picture.decode();
  const canvas = make("canvas", { width: 2 * width, height: 2 * height }, [], true), paint = canvas.getContext("2d");
  paint.fillStyle = "#fff";
  paint.fillRect(0, 0, canvas.width, canvas.height);
  paint.drawImage(picture, 0, 0, canvas.width, canvas.height);
  return canvas;
}

const cellText = (value) => {
  const text = value === null || value === undefined ? "" : String(value);
  return /[",\n]/.test(text) ? `"${text.replace(/"/g, '""')}"` : text;
};

/** "Save as PNG SVG CSV". what: { svg: () => the element, png: () => a canvas, csv: () => rows of cells }, those that there are. */
function savers(name, what) {
  const place = make("p", { class: "save" }, ["Save as "], true), file = `${document.body.dataset.file}-${name}`;
  const button = (text, act) => {
    const b = make("button", { type: "button", "aria-label": `Save ${name} as ${text}` }, [text], true);
    b.addEventListener("click", act);
    place.append(b, " ");
  };
  const png = what.png || (what.svg && (() => {
    const svg = what.svg(), [, , width, height] = svg.getAttribute("viewBox").split(" ").map(Number);
    return canvasOf(`data:image/svg+xml,${encodeURIComponent(svgText(svg))}`, width, height);
  }));
  if (png) button("PNG", async () => (await png()).toBlob((blob) => download(`${file}.png`, blob, "image/png")));
  if (what.svg) button("SVG", () => download(`${file}.svg`, svgText(what.svg()), "image/svg+xml"));
  if (what.csv) button("CSV", () => download(`${file}.csv`, what.csv().map((row) => row.map(cellText).join(",")).join("\n") + "\n", "text/csv"));
  return place;
}

/** A labelled check box. */
function check(label, on, changed) {
  const box = make("input", on ? { type: "checkbox", checked: "" } : { type: "checkbox" }, [], true);
  box.addEventListener("change", changed);
  return { element: make("label", { class: "choice" }, [box, " ", label], true), get: () => box.checked };
}
