// What both drawings share: elements, number formats, axes. No library, no network.
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

/** The frame of a plot with ticks and labels. box: left, top, width, height; x, y: { low, high, label, ticks, show }. */
function frame(box, x, y) {
  const group = make("g", { class: "axes" });
  const px = (v) => box.left + ((v - x.low) / (x.high - x.low)) * box.width;
  const py = (v) => box.top + box.height - ((v - y.low) / (y.high - y.low)) * box.height;
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
  const id = `choice-${++controls}`;
  const name = make("label", { for: id }, [label], true);
  if (values.length > 30) {
    const input = make("input", { id, type: "range", min: 0, max: values.length - 1, value: start, step: 1 }, [], true);
    const shown = make("output", { for: id }, [values[start]], true);
    input.addEventListener("input", () => {
      shown.textContent = values[input.value];
      input.setAttribute("aria-valuetext", values[input.value]);
      changed();
    });
    return { element: make("span", { class: "choice" }, [name, input, shown], true), get: () => Number(input.value) };
  }
  const options = values.map((v, i) => make("option", i === start ? { value: i, selected: "" } : { value: i }, [v], true));
  const select = make("select", { id }, options, true);
  select.addEventListener("change", changed);
  return { element: make("span", { class: "choice" }, [name, select], true), get: () => Number(select.value) };
}

/** A labelled check box. */
function check(label, on, changed) {
  const box = make("input", on ? { type: "checkbox", checked: "" } : { type: "checkbox" }, [], true);
  box.addEventListener("change", changed);
  return { element: make("label", { class: "choice" }, [box, " ", label], true), get: () => box.checked };
}
