// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0

/**
 * Builds the switches beside the map: #picture-<id> (one of the pictures, or none), #mark-<name> (each on or off), the opacity
 * of the picture, and its legend #legend.
 */
export function makePanel(element, { pictures, marks, onPicture, onOpacity, onMark }) {
  const legend = node("div", { id: "legend", "aria-live": "polite" });
  const choose = (id) => {
    onPicture(id);
    fillLegend(legend, pictures.find((picture) => picture.id === id));
  };

  if (pictures.length) {
    const options = [...pictures, { id: "none", title: "No picture" }].map(({ id, title }, k) =>
      choice({ type: "radio", name: "picture", id: `picture-${id}`, title, checked: k === 0 }, () => choose(id)),
    );
    element.append(group("Picture", options));
    const slider = node("input", { type: "range", id: "picture-opacity", min: "0", max: "100", value: "100" });
    slider.addEventListener("input", () => onOpacity(Number(slider.value) / 100));
    const label = node("label", { for: "picture-opacity", className: "opacity" }, "Opacity of the picture");
    label.append(slider);
    element.append(label, legend);
    choose(pictures[0].id);
  }

  const switches = marks.map(({ name, title, colour, dashed, shown }) => {
    const id = `mark-${name.replaceAll(" ", "-")}`;
    const swatch = node("span", { className: `swatch${dashed ? " dashed" : ""}` });
    swatch.style.borderColor = colour;
    return choice({ type: "checkbox", id, title, checked: shown, swatch }, (checked) => onMark(name, checked));
  });
  if (switches.length) element.append(group("Marks", switches));
  for (const { name, shown } of marks) if (shown) onMark(name, true);
}

function fillLegend(element, picture) {
  element.replaceChildren();
  if (!picture) return;
  const { legend, note } = picture;
  if (legend) {
    const ramp = node("span", { className: "ramp" });
    ramp.style.background = `linear-gradient(to right, ${legend.colours.join(",")})`;
    const both = legend.extend === "both";
    const low = `${both ? "≤ " : ""}${number(legend.low)}`;
    const high = `≥ ${number(legend.high)}`;
    const ends = node("span", { className: "ends" });
    ends.append(node("span", {}, low), node("span", {}, number((legend.low + legend.high) / 2)), node("span", {}, high));
    element.append(node("b", {}, legend.label), ramp, ends);
  }
  if (note) element.append(node("p", {}, note));
}

function choice({ type, name, id, title, checked, swatch }, onChange) {
  const input = node("input", { type, id });
  if (name) input.name = name;
  input.checked = checked;
  input.addEventListener("change", () => onChange(input.checked));
  const label = node("label", { for: id });
  label.append(input, ...(swatch ? [swatch] : []), node("span", {}, title));
  return label;
}

function group(title, children) {
  const set = node("fieldset", {});
  set.append(node("legend", {}, title), ...children);
  return set;
}

/** Makes an element with attributes and a text. */
export function node(tag, { className, ...attributes }, text) {
  const made = document.createElement(tag);
  if (className) made.className = className;
  for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
  if (text !== undefined) made.textContent = text;
  return made;
}

function number(value) {
  return String(Number(value.toPrecision(2))).replace("-", "−");
}
