// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
// Tiles of a mosaic, which lie in a folder beside the page where the picture in the page is reduced. Each is a script that hands its
// picture over as a data URI: of a page opened from disk a browser lets no picture file be drawn in 3-D.

window.hullreconTile = (uri) => (document.currentScript.uri = uri);

/** Returns a promise of a tile's data URI, which fails where the tile is missing: the page may be handed on without its folder. */
export function loadTile({ folder }, { level, column, row }) {
  return new Promise((resolve, reject) => {
    const script = document.createElement("script");
    script.src = `${folder}/${level}/${column}_${row}.js`;
    script.onload = () => resolve(script.uri);
    script.onerror = () => reject(new Error(`${script.src} is missing`));
    script.addEventListener("load", () => script.remove());
    script.addEventListener("error", () => script.remove());
    document.head.append(script);
  });
}

/** Returns the level that fits so many pixels a metre; the picture in the page has as much where it is not below levels.length. */
export function fittingLevel({ step_m: step }, pixelsPerMetre) {
  return Math.max(0, Math.floor(Math.log2(1 / (pixelsPerMetre * step)) + 0.01));
}

/** Returns the range of columns and rows of a level over a rectangle [left, bottom, right, top] of the map, last ones included. */
export function tileRange({ bounds, tiles }, [left, bottom, right, top], level) {
  const side = tileSide(tiles, level);
  const cell = (distance) => Math.max(0, Math.floor(distance / side));
  return { columns: [cell(left - bounds[0]), cell(right - bounds[0])], rows: [cell(bounds[3] - top), cell(bounds[3] - bottom)] };
}

/** Returns the tiles that are there in a range. */
export function tilesIn({ tiles: { levels } }, { columns, rows }, level) {
  const found = [];
  for (let row = rows[0]; row <= rows[1]; row++) {
    for (let column = columns[0]; column <= columns[1]; column++) {
      if (levels[level][row]?.[column] === "1") found.push({ level, column, row });
    }
  }
  return found;
}

/** Returns the side of a tile of a level, m. */
export function tileSide({ step_m: step, side_px: side }, level) {
  return step * side * 2 ** level;
}
