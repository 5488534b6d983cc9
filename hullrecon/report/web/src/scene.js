// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
import { Group, HemisphereLight, DirectionalLight, PerspectiveCamera, Scene, Vector3, WebGLRenderer } from "three";
import { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";
import "./scene.css";
import { makeGizmo } from "./scene_gizmo.js";
import { makeHull } from "./scene_hull.js";
import { makeMarks } from "./scene_marks.js";
import { makeScenePanel } from "./scene_panel.js";

const FIELD_DEG = 40;
const REST_MS = 150; // without a new picture of the view, before finer tiles are looked for

/** Shows the hull in 3-D inside an element when it is first scrolled to; data.scene is what scene_data.py wrote. */
export function mountScene(element, data, cards) {
  const start = () => {
    try {
      show(element, data, cards);
      element.dataset.state = "shown";
    } catch (error) {
      element.dataset.state = "none"; // the sentence and the still picture, which stand in the HTML, stay
      element.dataset.reason = String(error.message ?? error);
    }
  };
  const watch = new IntersectionObserver((entries) => {
    if (!entries.some((entry) => entry.isIntersecting)) return;
    watch.disconnect();
    start();
  }, { rootMargin: "200px" });
  watch.observe(element);
}

function show(element, data, cards) {
  if (!hasWebGL()) throw new Error("no WebGL");
  const canvas = document.createElement("canvas");
  const renderer = new WebGLRenderer({ canvas, antialias: true });
  renderer.setPixelRatio(Math.min(devicePixelRatio, 2));
  renderer.autoClear = false;
  renderer.setClearColor("#eef3f7");
  const view = element.querySelector(".scene-view");
  const bar = view.appendChild(document.createElement("div"));
  bar.className = "scene-bar";
  bar.append(document.createElement("span"), document.createElement("span"));
  view.append(canvas);
  canvas.tabIndex = 0;
  canvas.setAttribute("role", "application");
  canvas.setAttribute("aria-label", "The hull in 3-D. Arrow keys turn it, plus and minus come closer and go away, 0 shows all again.");

  const up = new Vector3(...data.scene.up);
  const scene = new Scene();
  const camera = new PerspectiveCamera(FIELD_DEG, 1, 0.05, 2000);
  camera.up.copy(up);
  const head = new Group(); // the light goes with the viewer
  head.add(new DirectionalLight("#fff", 1.9));
  scene.add(new HemisphereLight("#ffffff", "#8795a3", 1.5), head);

  let wanted = false;
  let rest = 0; // timer
  const draw = () => {
    if (wanted) return;
    wanted = true;
    requestAnimationFrame(() => {
      wanted = false;
      render();
    });
  };

  const hull = makeHull(data, draw);
  const marks = makeMarks(data, hull, up);
  scene.add(hull.group, marks.group);
  const gizmo = makeGizmo(data.scene);
  const controls = new OrbitControls(camera, canvas);
  controls.zoomToCursor = true;
  controls.addEventListener("change", draw);
  const home = () => placeCamera(camera, controls, hull, up);
  function render() {
    head.position.copy(camera.position);
    head.children[0].position.copy(up).multiplyScalar(0.3 * controls.getDistance());
    head.children[0].target.position.copy(controls.target);
    head.children[0].target.updateMatrixWorld();
    marks.face(camera);
    renderer.clear();
    renderer.render(scene, camera);
    gizmo.render(renderer, camera, canvas);
    scaleBar(bar, camera, controls, canvas);
    canvas.dataset.level = hull.detail.level();
    clearTimeout(rest);
    rest = setTimeout(() => hull.detail.update(renderer, camera, canvas), REST_MS);
  }

  new ResizeObserver(() => {
    const { clientWidth: width, clientHeight: height } = view;
    renderer.setSize(width, height, false);
    camera.aspect = width / height;
    camera.updateProjectionMatrix();
    draw();
  }).observe(view);

  moveByKeys(canvas, camera, controls, home);
  pickObjects(canvas, camera, marks, cards);
  makeScenePanel(element.querySelector(".scene-panel"), data, { hull, marks, home, draw });
  camera.aspect = view.clientWidth / view.clientHeight;
  home();
}

function hasWebGL() {
  return Boolean(document.createElement("canvas").getContext("webgl2"));
}

/** Looks at what was surveyed from outside, a little from above and from the side. */
function placeCamera(camera, controls, hull, up) {
  const { middle, radius, normal } = hull.surveyed;
  const side = new Vector3().crossVectors(up, normal).normalize();
  const from = normal.clone().addScaledVector(up, 0.25).addScaledVector(side, 0.35).normalize();
  const fit = radius / Math.sin(((FIELD_DEG / 2) * Math.PI) / 180);
  camera.position.copy(middle).addScaledVector(from, fit * (camera.aspect >= 1 ? 0.85 : 0.95 / camera.aspect));
  controls.target.copy(middle);
  controls.update();
}

function moveByKeys(canvas, camera, controls, home) {
  const turns = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };
  canvas.addEventListener("keydown", (event) => {
    const arm = camera.position.clone().sub(controls.target);
    if (event.key in turns) {
      const [around, over] = turns[event.key];
      const side = new Vector3().crossVectors(camera.up, arm).normalize();
      arm.applyAxisAngle(camera.up, (around * Math.PI) / 36).applyAxisAngle(side, (over * Math.PI) / 36);
      if (arm.angleTo(camera.up) < 0.05 || arm.angleTo(camera.up) > Math.PI - 0.05) return event.preventDefault();
    } else if (event.key === "+" || event.key === "=") arm.multiplyScalar(1 / 1.2);
    else if (event.key === "-") arm.multiplyScalar(1.2);
    else if (event.key === "0" || event.key === "Home") {
      event.preventDefault();
      return home();
    } else return undefined;
    event.preventDefault();
    camera.position.copy(controls.target).add(arm);
    return controls.update();
  });
}

/** A click, not a drag, near an object's number opens its card. */
function pickObjects(canvas, camera, marks, cards) {
  let pressed = null;
  canvas.addEventListener("pointerdown", (event) => (pressed = [event.clientX, event.clientY]));
  canvas.addEventListener("pointerup", (event) => {
    if (!pressed || Math.hypot(event.clientX - pressed[0], event.clientY - pressed[1]) > 5) return;
    const found = nearest(event);
    if (found !== null) cards?.open(found);
  });
  canvas.addEventListener("pointermove", (event) => {
    canvas.style.cursor = nearest(event) === null ? "" : "pointer";
  });
  function nearest(event) {
    const box = canvas.getBoundingClientRect();
    return marks.nearest(camera, event.clientX - box.left, event.clientY - box.top, box.width, box.height);
  }
}

/** A bar of a round length, true at the centre of the view. */
function scaleBar(bar, camera, controls, canvas) {
  const perPixel = (2 * controls.getDistance() * Math.tan((FIELD_DEG / 2) * (Math.PI / 180))) / canvas.clientHeight;
  const most = 140 * perPixel;
  const power = 10 ** Math.floor(Math.log10(most));
  const length = [5, 2, 1].map((m) => m * power).find((m) => m <= most);
  bar.firstElementChild.style.width = `${(length / perPixel).toFixed(1)}px`;
  bar.lastElementChild.textContent = length < 1 ? `${Number((100 * length).toPrecision(3))} cm` : `${length} m`;
}
