// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
const PLAIN = "plain";

/** Fills the panel beside the view: what lies on the hull, what is shown, and the sliders from the CAD model to the hull as found. */
export function makeScenePanel(panel, data, { hull, marks, home, draw }) {
  const pictures = data.map?.layers ?? [];
  const first = pictures.find((layer) => layer.id === "form") ?? pictures[0];
  const legend = make("div", { className: "scene-legend" });

  const choose = make("select", { id: "scene-picture" });
  choose.append(...[...pictures.map((layer) => [layer.id, layer.title]), [PLAIN, "Shape alone"]].map(([id, title]) => make("option", { value: id, textContent: title })));
  choose.value = first?.id ?? PLAIN;
  const paint = () => {
    hull.setPicture(choose.value);
    showLegend(legend, pictures.find((layer) => layer.id === choose.value));
  };
  choose.addEventListener("change", paint);
  panel.append(labelled("On the hull", choose), legend);

  const shown = [
    ["found", "Hull as found", hull.layers.found],
    ["cad", "CAD model, on the surveyed patch", hull.layers.cad],
    ["ship", data.scene.has_cad ? "Rest of the ship, by its CAD model" : "Not measured", hull.layers.ship],
    ["objects", "Objects", marks.layers.objects],
    ["path", "Path of the vehicle", marks.layers.path],
  ].filter(([, , layer]) => layer.isMesh || layer.children.length);
  const boxes = make("fieldset", {}, [make("legend", { textContent: "Shown" })]);
  for (const [name, title, layer] of shown) {
    const box = make("input", { type: "checkbox", id: `scene-${name}`, checked: layer.visible });
    box.addEventListener("change", () => {
      layer.visible = box.checked;
      draw();
    });
    boxes.append(make("label", { className: "scene-box" }, [box, make("span", { textContent: title })]));
  }
  panel.append(boxes);

  if (data.scene.has_form) panel.append(shapeSliders(hull));
  else hull.setShape(1, 1);
  const all = make("button", { type: "button", textContent: "Show all again" });
  all.addEventListener("click", home);
  panel.append(all);
  paint();
}

function shapeSliders(hull) {
  const shape = make("input", { type: "range", id: "scene-shape", min: 0, max: 1, step: 0.01, value: 1 });
  const factor = make("input", { type: "range", id: "scene-factor", min: 1, max: 20, step: 1, value: 1 });
  const says = make("output", {});
  const factorSays = make("output", {});
  const update = () => {
    hull.setShape(Number(shape.value), Number(factor.value));
    const percent = Math.round(100 * Number(shape.value));
    says.textContent = percent === 0 ? "CAD model" : percent === 100 ? "as found" : `${percent} %`;
    factorSays.textContent = factor.value === "1" ? "×1, true to scale" : `×${factor.value}, objects ×1`;
    shape.setAttribute("aria-valuetext", says.textContent);
    factor.setAttribute("aria-valuetext", factorSays.textContent);
  };
  shape.addEventListener("input", update);
  factor.addEventListener("input", update);
  update();
  return make("fieldset", {}, [
    make("legend", { textContent: "Form" }),
    make("label", {}, ["CAD model – as found: ", says, shape]),
    make("label", {}, ["Relief of the hull: ", factorSays, factor]),
  ]);
}

function showLegend(element, layer) {
  element.replaceChildren();
  if (!layer?.legend) return;
  const { label, low, high, colours, extend } = layer.legend;
  const strip = make("span", { className: "scene-colours" });
  strip.style.background = `linear-gradient(to right, ${colours.join(", ")})`;
  element.append(make("span", { textContent: label }), strip, make("span", { className: "scene-ends" }, [(extend === "both" ? "≤ " : "") + rounded(low), `≥ ${rounded(high)}`].map((text) => make("span", { textContent: text }))));
}

function rounded(value) {
  return String(Number(value.toPrecision(2))).replace("-", "−");
}

function labelled(text, control) {
  return make("label", {}, [`${text} `, control]);
}

function make(tag, properties, children = []) {
  const element = Object.assign(document.createElement(tag), properties);
  element.append(...children);
  return element;
}
