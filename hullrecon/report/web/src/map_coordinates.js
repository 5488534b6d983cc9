// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
import { node } from "./map_panel.js";
import { readPixels } from "./pictures.js";

const APART_PX = 90; // ticks that are nearer would touch

/** Adds ticks along two edges, a scale bar in metres, and a readout of the place (and value) under the pointer to a map. */
export function showCoordinates(map, about, pictures) {
  const container = map.getContainer();
  const ticks = node("div", { className: "map-ticks", "aria-hidden": "true" });
  const scale = node("div", { className: "map-scale" });
  const readout = node("div", { className: "map-readout", id: "map-readout" });
  container.append(ticks, scale, readout);

  const draw = () => {
    drawTicks(map, about, ticks);
    drawScale(map, scale);
  };
  map.on("move zoom resize", draw);
  draw();

  const values = valueReader();
  map.on("mousemove", ({ latlng }) => {
    const value = values(pictures.current(), latlng);
    readout.textContent = describePosition(about, latlng) + (value ? ` · ${value}` : "");
  });
  map.on("mouseout", () => (readout.textContent = ""));
}

function describePosition({ axes, x_sign, y_sign, frame_spacing }, { lng, lat }) {
  const along = x_sign * lng;
  const girth = y_sign * lat;
  const side = axes[1] === "girth" ? (girth > 0 ? " (port)" : " (starboard)") : "";
  const frame = frame_spacing ? ` · frame ${(along / frame_spacing).toFixed(1)}` : "";
  return `${axes[0]} ${along.toFixed(2)} m · ${axes[1]} ${girth.toFixed(2)} m${side}${frame}`;
}

/** Returns a function that reads a picture's value at a place from the colour of its pixel; "" where it has none. */
function valueReader() {
  const read = new Map(); // by layer: what is known of its pixels; null while they are decoded
  return (layer, { lng, lat }) => {
    if (!layer?.legend) return "";
    if (!read.has(layer.id)) {
      read.set(layer.id, null);
      const level = new Map(layer.legend.colours.map((colour, k) => [parseInt(colour.slice(1), 16), k]));
      readPixels(layer.image).then((pixels) => read.set(layer.id, { pixels, level }));
    }
    const known = read.get(layer.id);
    if (!known) return "";
    const [left, bottom, right, top] = layer.bounds;
    const { width, height, data } = known.pixels;
    const column = Math.floor(((lng - left) / (right - left)) * width);
    const row = Math.floor(((top - lat) / (top - bottom)) * height);
    if (column < 0 || row < 0 || column >= width || row >= height) return "";
    const at = 4 * (row * width + column);
    if (!data[at + 3]) return "";
    const level = known.level.get((data[at] << 16) | (data[at + 1] << 8) | data[at + 2]);
    return level === undefined ? "" : valueWords(layer.legend, level);
  };
}

function valueWords({ label, low, high, extend }, level) {
  const [, name, unit] = label.match(/^(.*?)(?: \((.*)\))?$/);
  const beyond = level === 255 ? "≥ " : level === 0 && extend === "both" ? "≤ " : "";
  const value = low + ((high - low) * level) / 255;
  return `${name} ${beyond}${value.toFixed(high - low < 20 ? 1 : 0).replace("-", "−")}${unit ? ` ${unit}` : ""}`;
}

function drawTicks(map, { x_sign, y_sign }, element) {
  const bounds = map.getBounds();
  const { x: width, y: height } = map.getSize();
  const perMetre = width / (bounds.getEast() - bounds.getWest());
  const step = niceStep(APART_PX / perMetre);
  const digits = Math.max(0, -Math.floor(Math.log10(step) + 1e-9));
  const made = [];
  for (const x of multiples(bounds.getWest(), bounds.getEast(), step)) {
    const at = map.latLngToContainerPoint([bounds.getSouth(), x]).x;
    if (at > 40 && at < width - 30) made.push(tick("x", at, `${(x_sign * x + 0).toFixed(digits)} m`));
  }
  for (const y of multiples(bounds.getSouth(), bounds.getNorth(), step)) {
    const at = map.latLngToContainerPoint([y, bounds.getWest()]).y;
    if (at > 90 && at < height - 40) made.push(tick("y", at, `${(y_sign * y + 0).toFixed(digits)} m`));
  }
  element.replaceChildren(...made);
}

function tick(axis, at, text) {
  const made = node("span", { className: axis }, text);
  made.style[axis === "x" ? "left" : "top"] = `${at}px`;
  return made;
}

function drawScale(map, element) {
  const perMetre = 2 ** map.getZoom();
  const metres = niceStep(60 / perMetre);
  element.textContent = metres < 1 ? `${Math.round(100 * metres)} cm` : `${metres} m`;
  element.style.width = `${metres * perMetre}px`;
}

/** Returns the least of 1, 2, 5 times a power of ten that is not below a length. */
export function niceStep(least) {
  const power = 10 ** Math.floor(Math.log10(least));
  return Number(([1, 2, 5, 10].find((m) => m * power >= least * (1 - 1e-9)) * power).toPrecision(1));
}

function multiples(low, high, step) {
  const first = Math.ceil(low / step);
  return Array.from({ length: Math.max(0, Math.floor(high / step) - first + 1) }, (_, k) => (first + k) * step);
}
