// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
import { BufferAttribute, BufferGeometry, DoubleSide, Group, Mesh, MeshLambertMaterial, SRGBColorSpace, TextureLoader, Vector3 } from "three";
import { pictureUri } from "./pictures.js";
import { makeDetail } from "./scene_detail.js";

const GREY = "#b9c2ca";
const SHARP = `
uniform sampler2D sharp;
uniform vec4 sharpBox;
float within(vec2 place) {
  return all(greaterThanEqual(place, vec2(0.0))) && all(lessThanEqual(place, vec2(1.0))) ? 1.0 : 0.0;
}
`;

/** The hull as found, with a picture of the map on it, and its CAD model; setShape(t, factor) goes from one to the other. */
export function makeHull(data, draw) {
  const bytes = decode(document.getElementById(data.scene.block).textContent.trim());
  const surveyed = unpack(data.scene.surveyed, bytes);
  const rest = data.scene.rest && unpack(data.scene.rest, bytes);
  const group = new Group();

  const found = new Mesh(surveyed.geometry(), new MeshLambertMaterial({ color: GREY, side: DoubleSide }));
  group.add(found);
  const cad = new Group();
  if (data.scene.has_cad) {
    const ghost = new MeshLambertMaterial({ color: "#2b6cb0", transparent: true, opacity: 0.35, side: DoubleSide, depthWrite: false });
    cad.add(new Mesh(surveyed.geometry(), ghost));
  }
  const ship = new Group();
  if (rest) ship.add(new Mesh(rest.geometry(), new MeshLambertMaterial({ color: "#d3dae0", side: DoubleSide })));
  group.add(cad, ship);
  cad.visible = false;

  const textures = new Map();
  const detail = makeDetail(found, draw);
  function setPicture(id) {
    const layer = data.map?.layers.find((one) => one.id === id);
    const material = found.material;
    detail.setLayer(layer);
    if (!layer) {
      Object.assign(material, { map: null, needsUpdate: true });
      return draw();
    }
    if (!textures.has(id)) {
      const texture = new TextureLoader().load(pictureUri(layer.image), () => draw());
      texture.colorSpace = SRGBColorSpace;
      texture.anisotropy = 8;
      textures.set(id, texture);
    }
    found.geometry.setAttribute("uv", new BufferAttribute(surveyed.uv(layer.bounds), 2));
    Object.assign(material, { map: textures.get(id), needsUpdate: true });
    overGrey(material, detail.uniforms);
    return draw();
  }

  return {
    group,
    layers: { found, cad, ship },
    surveyed: surveyed.extent(),
    setPicture,
    detail,
    /** t: 0 as the CAD model has it, 1 as found; factor: how often its relief is added; objects stay true to scale. */
    setShape(t, factor) {
      surveyed.shape(found.geometry, t, factor);
      draw();
    },
  };
}

/** Where the picture is transparent the hull is grey, not white. The sharp texture lies over the picture. */
function overGrey(material, uniforms) {
  material.onBeforeCompile = (shader) => {
    Object.assign(shader.uniforms, uniforms);
    shader.fragmentShader = SHARP + shader.fragmentShader;
    shader.fragmentShader = shader.fragmentShader.replace(
      "#include <map_fragment>",
      `#ifdef USE_MAP
      vec4 pictured = texture2D(map, vMapUv);
      pictured = within(vMapUv) * vec4(pictured.rgb * pictured.a, pictured.a);
      vec2 inSharp = (vMapUv - sharpBox.xy) / sharpBox.zw;
      vec4 above = within(inSharp) * texture2D(sharp, inSharp);
      pictured = above + (1.0 - above.a) * pictured;
      diffuseColor.rgb = pictured.rgb + (1.0 - pictured.a) * diffuseColor.rgb;
      #endif`,
    );
  };
}

/** Returns the vertex nearest to a point: the middle of a curved patch lies inside the ship. */
function nearestVertex(geometry, point) {
  const positions = geometry.getAttribute("position");
  const nearest = new Vector3();
  const vertex = new Vector3();
  let least = Infinity;
  for (let k = 0; k < positions.count; k++) {
    const distance = vertex.fromBufferAttribute(positions, k).distanceToSquared(point);
    if (distance >= least) continue;
    least = distance;
    nearest.copy(vertex);
  }
  return nearest;
}

function decode(text) {
  const raw = atob(text);
  const bytes = new Uint8Array(raw.length);
  for (let k = 0; k < raw.length; k++) bytes[k] = raw.charCodeAt(k);
  return bytes.buffer;
}

function unpack(part, buffer) {
  const n = part.count;
  const steps = new Uint16Array(buffer, part.vertices, 3 * n);
  const form = new Int16Array(buffer, part.form, n);
  const relief = new Int16Array(buffer, part.relief, n);
  const normals = new Int8Array(buffer, part.normals, 3 * n);
  const map = new Float32Array(buffer, part.map, 2 * n);
  const faces = new Uint32Array(buffer, part.faces, 3 * part.triangles);
  const base = new Float32Array(3 * n);
  for (let k = 0; k < 3 * n; k++) base[k] = part.low[k % 3] + steps[k] * part.step[k % 3];

  function shape(geometry, t, factor) {
    const at = geometry.getAttribute("position");
    for (let k = 0; k < n; k++) {
      const shown = t * part.form_step_m * (form[k] + (factor - 1) * relief[k]);
      for (let axis = 3 * k; axis < 3 * k + 3; axis++) at.array[axis] = base[axis] + (shown * normals[axis]) / 127;
    }
    at.needsUpdate = true;
    geometry.computeVertexNormals();
  }

  return {
    shape,
    geometry() {
      const geometry = new BufferGeometry();
      geometry.setAttribute("position", new BufferAttribute(base.slice(), 3));
      geometry.setIndex(new BufferAttribute(faces, 1));
      geometry.computeVertexNormals();
      geometry.computeBoundingSphere();
      return geometry;
    },
    uv([left, bottom, right, top]) {
      const uv = new Float32Array(2 * n);
      for (let k = 0; k < n; k++) {
        const [x, y] = [map[2 * k], map[2 * k + 1]];
        const off = Number.isNaN(x) || Number.isNaN(y);
        uv[2 * k] = off ? -1 : (x - left) / (right - left);
        uv[2 * k + 1] = off ? -1 : (y - bottom) / (top - bottom);
      }
      return uv;
    },
    extent() {
      const geometry = this.geometry();
      const normal = new Vector3();
      const normals = geometry.getAttribute("normal");
      for (let k = 0; k < n; k += 7) normal.add(new Vector3().fromBufferAttribute(normals, k));
      const { center, radius } = geometry.boundingSphere;
      return { middle: nearestVertex(geometry, center), radius, normal: normal.lengthSq() > 0 ? normal.normalize() : new Vector3(0, 1, 0) };
    },
  };
}
