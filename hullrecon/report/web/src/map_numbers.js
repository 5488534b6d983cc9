// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0

const ROUNDS = 100;

/**
 * Moves markers that lie nearer to each other than apartPx on the screen away from each other, at the map's present zoom; a leader
 * runs from the place itself to a marker that was moved. placed: [{marker, leader, at}].
 */
export function spreadNumbers(map, placed, apartPx) {
  const there = placed.map(({ at }) => map.project(at));
  const moved = pushApart(there, apartPx);
  placed.forEach(({ marker, leader, at }, k) => {
    const still = moved[k].equals(there[k]);
    marker.setLatLng(still ? at : map.unproject(moved[k]));
    leader.setLatLngs(still ? [] : [at, map.unproject(moved[k])]);
  });
}

/** Returns the points with none nearer to another than apart, as far as rounds of pushing pairs apart get. */
function pushApart(points, apart) {
  const moved = points.map((point) => point.clone());
  for (let round = 0; round < ROUNDS; round += 1) {
    let done = true;
    for (let j = 1; j < moved.length; j += 1) {
      for (let i = 0; i < j; i += 1) {
        const distance = moved[i].distanceTo(moved[j]);
        if (distance >= apart) continue;
        const away = distance > 0 ? moved[j].subtract(moved[i]).divideBy(distance) : { x: 1, y: 0 };
        const step = (apart - distance) / 2 + 0.01;
        moved[j]._add({ x: step * away.x, y: step * away.y });
        moved[i]._subtract({ x: step * away.x, y: step * away.y });
        done = false;
      }
    }
    if (done) break;
  }
  return moved;
}
