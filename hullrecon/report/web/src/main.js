// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
// Makes the page live. All words and pictures stand in the HTML already, for readers without JavaScript; data is what
// hullrecon/report/content/page_data.py wrote into #report-data.
//
// Elements that are found by their id:
//   #map      the map of the hull           (map.js)
//   #objects  the section with the table of objects, whose rows are #row-<id> (table.js)
//   #card     the card that is open, in a dialog; the cards in the page are #object-<id> (cards.js)
//   #scene    the hull in 3-D               (scene.js)
import "leaflet/dist/leaflet.css";
import "./style.css";
import { mountCards } from "./cards.js";
import { mountMap } from "./map.js";
import { mountScene } from "./scene.js";
import { mountTable } from "./table.js";

function start() {
  const data = JSON.parse(document.getElementById("report-data").textContent);
  const cards = mountCards();
  const map = data.map && mountMap(document.getElementById("map"), data, cards);
  mountTable(document.getElementById("object-table"), map, cards);
  const scene = document.getElementById("scene");
  if (scene && data.scene) mountScene(scene, data, cards);
}

start();
