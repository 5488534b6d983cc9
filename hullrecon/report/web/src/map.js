// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
import * as L from "leaflet/dist/leaflet-src.esm.js";
import { showCoordinates } from "./map_coordinates.js";
import { spreadNumbers } from "./map_numbers.js";
import { makePanel } from "./map_panel.js";
import { makeTiles } from "./map_tiles.js";
import { pictureUri } from "./pictures.js";

const CLOSEST_PX_PER_M = 4000; // four screen pixels for a pixel of the finest mosaic
const APART_PX = 28; // between the middles of two objects' numbers, of 26 px: neighbours are told apart and can be touched
const LINK_COLOURS = { "along the track": "#1f5f99", "between legs": "#c8541b" };

/**
 * Shows data.map in an element, in map coordinates (metres, x right, y up): one picture at a time over the camera mosaic, and
 * marks that can be switched. Returns {show(id)}, which brings an object into view, and setLayer(id).
 */
export function mountMap(element, data, cards) {
  const map = L.map(element, { crs: L.CRS.Simple, zoomSnap: 0.1, zoomDelta: 0.5, preferCanvas: true, attributionControl: false });
  keepFitted(map, box(data.map.bounds));
  map.setMaxZoom(Math.log2(CLOSEST_PX_PER_M)).setMaxBounds(box(data.map.bounds).pad(0.5));

  const pictures = stackPictures(map, data.map.layers);
  const marks = makeMarks(data, cards);
  makePanel(document.getElementById("map-panel"), {
    pictures: data.map.layers,
    marks: Object.entries(marks).map(([name, mark]) => ({ name, ...mark })),
    onPicture: pictures.show,
    onOpacity: pictures.setOpacity,
    onMark: (name, shown) => (shown ? marks[name].layer.addTo(map) : marks[name].layer.remove()),
  });
  showCoordinates(map, data.map, pictures);
  const thin = () => {
    const dense = crowded(map, data);
    element.classList.toggle("dense", dense);
    spreadNumbers(map, marks.objects?.placed ?? [], dense ? 0 : APART_PX);
  };
  map.on("zoomend", thin);
  thin();

  return {
    setLayer: pictures.show,
    show(id) {
      const found = data.objects.find((object) => String(object.id) === String(id));
      if (!found?.at) return;
      const around = L.latLngBounds([latLng(found.at), ...found.outline.map(latLng)]).pad(1.5);
      map.fitBounds(around, { maxZoom: Math.log2(600) });
      element.scrollIntoView({ block: "center" });
      marks.objects.byId.get(String(id))?.getElement()?.focus({ preventScroll: true });
    },
  };
}

/** Shows a rectangle whole, and does so again when the element's size changes, until a reader has moved the map. */
function keepFitted(map, bounds) {
  let fitted = null;
  const fit = () => {
    map.setMinZoom(map.getBoundsZoom(bounds) - 1);
    map.fitBounds(bounds, { animate: false });
    fitted = { zoom: map.getZoom(), center: map.getCenter() };
  };
  fit();
  new ResizeObserver(() => {
    const untouched = map.getZoom() === fitted.zoom && map.getCenter().equals(fitted.center, 1e-6);
    map.invalidateSize({ animate: false, pan: false });
    if (untouched) fit();
  }).observe(map.getContainer());
}

/** Returns whether the objects' numbers would cover each other at this zoom. */
function crowded(map, { objects, map: { bounds } }) {
  const area = (bounds[2] - bounds[0]) * (bounds[3] - bounds[1]) * 4 ** map.getZoom();
  return Math.sqrt(area / Math.max(objects.length, 1)) < 45;
}

/** The pictures: one shown on top, the camera mosaic below it, so that a transparent one lies on what the hull looks like. */
function stackPictures(map, layers) {
  const made = new Map();
  let current = null;
  let opacity = 1;
  const ground = layers.find((layer) => !layer.legend);
  const tiles = makeTiles(map);

  function overlay(layer) {
    if (!made.has(layer.id)) {
      const picture = L.imageOverlay(pictureUri(layer.image), box(layer.bounds), { className: `picture-${layer.id}` });
      made.set(layer.id, picture);
    }
    return made.get(layer.id);
  }

  function draw() {
    const below = current && ground && current !== ground && opacity < 1 ? ground : null;
    for (const [id, picture] of made) if (id !== current?.id && id !== below?.id) picture.remove();
    if (below) overlay(below).setOpacity(1).setZIndex(1).addTo(map);
    if (current) overlay(current).setOpacity(opacity).setZIndex(below ? 3 : 1).addTo(map);
    tiles.show(below ?? (opacity === 1 ? current : null)); // of a faint picture they would be seen twice
    map.getContainer().dataset.picture = current?.id ?? "";
  }

  return {
    current: () => current,
    show(id) {
      current = layers.find((layer) => layer.id === id) ?? null;
      draw();
    },
    setOpacity(value) {
      opacity = value;
      draw();
    },
  };
}

/** The marks by name: {title, colour, layer, shown}. */
function makeMarks(data, cards) {
  const marks = {};
  if (data.objects.length) {
    const numbers = L.layerGroup();
    const byId = new Map();
    const placed = [];
    for (const found of data.objects.filter((object) => object.at)) {
      const open = () => cards.open(found.id);
      if (found.outline.length > 2) {
        L.polygon(found.outline.map(latLng), { color: "#c8541b", weight: 2, fillOpacity: 0.12 }).on("click", open).addTo(numbers);
      }
      const marker = number(found).on("click", open).on("keypress", (event) => event.originalEvent.key === "Enter" && open());
      const leader = L.polyline([], { color: "#b3470f", weight: 1.5, interactive: false });
      byId.set(String(found.id), marker);
      placed.push({ marker, leader, at: latLng(found.at) });
      leader.addTo(numbers);
      marker.addTo(numbers);
    }
    marks.objects = { title: "Objects with their outlines", colour: "#c8541b", layer: numbers, shown: true, byId, placed };
    const rings = data.objects.filter((object) => object.ellipse.length).map((object) => object.ellipse.map(latLng));
    if (rings.length) {
      const style = { color: "#c8541b", weight: 1.5, dashArray: "5 4", fillOpacity: 0.06, interactive: false };
      marks.sigma = { title: "One-sigma ellipse of each object's place", colour: "#c8541b", dashed: true, layer: L.polygon(rings.map((ring) => [ring]), style), shown: false };
    }
  }
  if (data.map.path.length) {
    const lines = data.map.path.map((piece) => piece.map(latLng));
    const path = L.layerGroup([L.polyline(lines, { color: "#fff", weight: 4.5, opacity: 0.7, interactive: false }), L.polyline(lines, { color: "#14304d", weight: 2, interactive: false })]);
    dot(lines[0][0], "start", "#2b7a4b").addTo(path);
    dot(lines.at(-1).at(-1), "end", "#14304d").addTo(path);
    marks.path = { title: "Path of the vehicle", colour: "#14304d", layer: path, shown: data.map.layers.length === 0 };
  }
  for (const { kind, segments } of data.map.links) {
    const colour = LINK_COLOURS[kind] ?? "#6b3fa0";
    const lines = segments.map(([x0, y0, x1, y1]) => [latLng([x0, y0]), latLng([x1, y1])]);
    marks[`links ${kind}`] = { title: `Matched images, ${kind}`, colour, layer: L.polyline(lines, { color: colour, weight: 1, opacity: 0.7, interactive: false }), shown: false };
  }
  return marks;
}

function number(found) {
  const title = `Object ${found.id}: ${found.kind}, height ${found.height.toFixed(3)} m. Open its card.`;
  const icon = L.divIcon({ className: "map-number", html: `<span>${Number(found.id)}</span>`, iconSize: [26, 26] });
  const marker = L.marker(latLng(found.at), { icon, title, alt: title, riseOnHover: true });
  marker.on("add", () => marker.getElement().setAttribute("aria-label", title));
  return marker;
}

function dot(at, name, colour) {
  const marker = L.circleMarker(at, { radius: 5, color: "#fff", weight: 1.5, fillColor: colour, fillOpacity: 1, interactive: false });
  return marker.bindTooltip(name, { permanent: true, direction: "right", offset: [6, 0], className: "map-end" });
}

export function latLng([x, y]) {
  return L.latLng(y, x);
}

function box([left, bottom, right, top]) {
  return L.latLngBounds([bottom, left], [top, right]);
}
