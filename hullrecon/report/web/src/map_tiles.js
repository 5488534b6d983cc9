// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
import * as L from "leaflet/dist/leaflet-src.esm.js";

/**
 * Shows the tiles of a layer, which lie in a folder beside the page, over its picture in the page: those in view, at the level that
 * fits the screen. Where a tile is missing, or all are because the page was handed on without them, the picture stays.
 */
export function makeTiles(map) {
  const shown = new Map(); // overlays by address
  let current = null;

  function draw() {
    const wanted = current ? new Map(tilesInView(map, current).map((tile) => [tile.url, tile.bounds])) : new Map();
    for (const [url, overlay] of shown) {
      if (wanted.has(url)) continue;
      overlay.remove();
      shown.delete(url);
    }
    for (const [url, bounds] of wanted) {
      if (shown.has(url)) continue;
      const overlay = L.imageOverlay(url, bounds, { className: "map-tile", zIndex: 2 });
      overlay.on("error", () => overlay.remove());
      shown.set(url, overlay.addTo(map));
    }
  }

  map.on("moveend zoomend resize", draw);
  return {
    /** Shows the tiles of a layer, none if it is null or has none. */
    show(layer) {
      current = layer?.tiles ? layer : null;
      draw();
    },
  };
}

function tilesInView(map, { bounds: [left, bottom, right, top], tiles: { folder, step_m: step, side_px: side, levels } }) {
  const pixelsPerMetre = 2 ** map.getZoom() * (window.devicePixelRatio || 1);
  const level = Math.max(0, Math.floor(Math.log2(1 / (pixelsPerMetre * step)) + 0.01));
  if (level >= levels.length) return []; // the picture in the page has as much
  const metres = step * side * 2 ** level; // side of a tile
  const view = map.getBounds();
  const found = [];
  for (let row = cell(top - view.getNorth(), metres); row <= cell(top - view.getSouth(), metres); row++) {
    for (let column = cell(view.getWest() - left, metres); column <= cell(view.getEast() - left, metres); column++) {
      if (levels[level][row]?.[column] !== "1") continue;
      const [west, north] = [left + column * metres, top - row * metres];
      const corners = [[Math.max(bottom, north - metres), west], [north, Math.min(right, west + metres)]];
      found.push({ url: `${folder}/${level}/${column}_${row}.webp`, bounds: L.latLngBounds(corners) });
    }
  }
  return found;
}

function cell(distance, side) {
  return Math.max(0, Math.floor(distance / side));
}
