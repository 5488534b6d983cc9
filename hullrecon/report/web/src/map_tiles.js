// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
import * as L from "leaflet/dist/leaflet-src.esm.js";
import { fittingLevel, loadTile, tileRange, tileSide, tilesIn } from "./tiles.js";

/**
 * Shows the tiles of a layer over its picture in the page: those in view, at the level that fits the screen. Where a tile is
 * missing, or all are because the page was handed on without them, the picture stays.
 */
export function makeTiles(map) {
  const shown = new Map(); // overlays by layer and tile, null while a tile is loaded
  let current = null;

  function draw() {
    const wanted = new Map(current ? tilesInView(map, current).map((tile) => [nameOf(current, tile), tile]) : []);
    for (const [name, overlay] of shown) {
      if (wanted.has(name)) continue;
      overlay?.remove();
      shown.delete(name);
    }
    for (const [name, tile] of wanted) if (!shown.has(name)) add(current, name, tile);
  }

  function add(layer, name, tile) {
    shown.set(name, null);
    loadTile(layer.tiles, tile).then(
      (uri) => {
        if (shown.get(name) !== null) return; // out of view by now, or there already
        const overlay = L.imageOverlay(uri, boundsOf(layer, tile), { className: "map-tile", zIndex: 2 });
        shown.set(name, overlay.addTo(map));
      },
      () => {}, // the picture stays
    );
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

function nameOf(layer, { level, column, row }) {
  return [layer.id, level, column, row].join();
}

function tilesInView(map, layer) {
  const level = fittingLevel(layer.tiles, 2 ** map.getZoom() * (window.devicePixelRatio || 1));
  if (level >= layer.tiles.levels.length) return []; // the picture in the page has as much
  const view = map.getBounds();
  const rectangle = [view.getWest(), view.getSouth(), view.getEast(), view.getNorth()];
  return tilesIn(layer, tileRange(layer, rectangle, level), level);
}

function boundsOf({ bounds: [left, bottom, right, top], tiles }, { level, column, row }) {
  const side = tileSide(tiles, level);
  const [west, north] = [left + column * side, top - row * side];
  return L.latLngBounds([Math.max(bottom, north - side), west], [north, Math.min(right, west + side)]);
}
