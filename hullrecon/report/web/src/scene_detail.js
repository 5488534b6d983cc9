// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
import { CanvasTexture, DoubleSide, FloatType, Mesh, SRGBColorSpace, Scene, ShaderMaterial, Vector4, WebGLRenderTarget } from "three";
import { fittingLevel, loadTile, tileRange, tileSide, tilesIn } from "./tiles.js";

const PROBES = [64, 48]; // places on the screen, across and down, at which the hull is looked up
const MOST_PX = 4096; // a side of the sharp texture: 64 MB, and what every WebGL 2 takes
const DEPTHS = 2; // what is further away than so many times the nearest needs a coarser texture: the picture serves there
const NOWHERE = new Vector4(2, 2, 1, 1);

/**
 * A second texture for the part of the hull in view, put together from tiles of the mosaic, where its picture in the page is too
 * coarse. uniforms: the texture and its box (left, bottom, width, height) in shares of the picture.
 */
export function makeDetail(hull, draw) {
  const uniforms = { sharp: { value: null }, sharpBox: { value: NOWHERE } };
  const probe = makeProbe(hull);
  let layer = null;
  let name = ""; // of what is shown or loaded

  function put(texture, box) {
    uniforms.sharp.value?.dispose();
    [uniforms.sharp.value, uniforms.sharpBox.value] = [texture, box];
    draw();
  }

  function show(wanted) {
    const next = wanted ? [wanted.level, ...wanted.columns, ...wanted.rows].join() : "";
    if (next === name) return;
    name = next;
    if (!wanted) put(null, NOWHERE);
    else compose(layer, wanted).then((canvas) => canvas && name === next && put(textureOf(canvas), boxOf(layer, wanted)));
  }

  return {
    uniforms,
    /** Sets the picture whose tiles are taken, null for none. */
    setLayer(next) {
      show(null);
      layer = next?.tiles ? next : null;
    },
    /** Looks at what is in view, and loads its tiles. */
    update(renderer, camera, canvas) {
      if (layer) show(wantedRange(layer, probe.look(renderer, camera), camera, canvas));
    },
    /** The level that is shown, -1 for none. */
    level: () => (uniforms.sharp.value ? Number(name.split(",")[0]) : -1),
  };
}

/** Draws place in the picture and depth of the hull, small, to be read back. */
function makeProbe(hull) {
  const [width, height] = PROBES;
  const scene = new Scene();
  const material = new ShaderMaterial({
    side: DoubleSide,
    vertexShader: `
      varying vec3 place;
      void main() {
        vec4 seen = modelViewMatrix * vec4(position, 1.0);
        place = vec3(uv, -seen.z);
        gl_Position = projectionMatrix * seen;
      }`,
    fragmentShader: "varying vec3 place; void main() { gl_FragColor = vec4(place, 1.0); }",
  });
  scene.add(new Mesh(hull.geometry, material));
  const target = new WebGLRenderTarget(width, height, { type: FloatType });
  const values = new Float32Array(4 * width * height);
  return {
    /** Returns [{u, v, depth}] where the hull is in view. */
    look(renderer, camera) {
      if (!renderer.extensions.has("EXT_color_buffer_float")) return [];
      renderer.setClearAlpha(0);
      renderer.setRenderTarget(target);
      renderer.clear();
      renderer.render(scene, camera);
      renderer.readRenderTargetPixels(target, 0, 0, width, height, values);
      renderer.setRenderTarget(null);
      renderer.setClearAlpha(1);
      const found = [];
      for (let k = 0; k < values.length; k += 4) {
        const [u, v, depth, hit] = values.subarray(k, k + 4);
        if (hit > 0 && u >= 0 && u <= 1 && v >= 0 && v <= 1) found.push({ u, v, depth });
      }
      return found;
    },
  };
}

/** Returns level and range of the tiles that are wanted, null where the picture has as much as the screen shows. */
function wantedRange(layer, places, camera, canvas) {
  if (!places.length) return null;
  const [left, bottom, right, top] = layer.bounds;
  const nearest = places.reduce((least, { depth }) => Math.min(least, depth), Infinity);
  const near = places.filter(({ depth }) => depth <= DEPTHS * nearest);
  const [u, v] = ["u", "v"].map((axis) => near.map((one) => one[axis]).sort((a, b) => a - b));
  const margin = 2 / PROBES[0]; // between the outermost places and the edge of what is in view
  const [du, dv] = [u, v].map((all) => margin * (all.at(-1) - all[0]));
  const across = (share) => left + share * (right - left);
  const up = (share) => bottom + share * (top - bottom);
  const view = [across(u[0] - du), up(v[0] - dv), across(u.at(-1) + du), up(v.at(-1) + dv)];
  const pixelsPerMetre = canvas.height / (2 * nearest * Math.tan((camera.fov / 2) * (Math.PI / 180)));
  for (let level = fittingLevel(layer.tiles, pixelsPerMetre); level < layer.tiles.levels.length; level++) {
    const range = tileRange(layer, view, level);
    const most = Math.max(...[range.columns, range.rows].map(([first, last]) => last - first + 1));
    if (most * layer.tiles.side_px <= MOST_PX) return { level, ...range };
  }
  return null;
}

/** Returns a promise of a canvas with the tiles of a range, transparent where one is missing; of null where all are. */
async function compose(layer, { level, columns, rows }) {
  const side = layer.tiles.side_px;
  const canvas = document.createElement("canvas");
  [canvas.width, canvas.height] = [columns, rows].map(([first, last]) => (last - first + 1) * side);
  const pen = canvas.getContext("2d");
  const paint = async (tile) => {
    const image = new Image();
    image.src = await loadTile(layer.tiles, tile);
    await image.decode();
    pen.drawImage(image, (tile.column - columns[0]) * side, (tile.row - rows[0]) * side);
  };
  const painted = await Promise.allSettled(tilesIn(layer, { columns, rows }, level).map(paint));
  return painted.some(({ status }) => status === "fulfilled") ? canvas : null;
}

function textureOf(canvas) {
  const texture = new CanvasTexture(canvas);
  Object.assign(texture, { colorSpace: SRGBColorSpace, anisotropy: 8, premultiplyAlpha: true });
  return texture;
}

/** Returns where a range lies in the picture, in shares of it. */
function boxOf({ bounds: [left, bottom, right, top], tiles }, { level, columns, rows }) {
  const side = tileSide(tiles, level);
  const [width, height] = [columns, rows].map(([first, last]) => (last - first + 1) * side);
  const low = top - rows[0] * side - height;
  return new Vector4((columns[0] * side) / (right - left), (low - bottom) / (top - bottom), width / (right - left), height / (top - bottom));
}
