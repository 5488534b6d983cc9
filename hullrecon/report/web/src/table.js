// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0

const order = new Intl.Collator("en", { numeric: true });

/** Makes the table of objects sortable by its headings and filterable by a text; rows lead to map and card. */
export function mountTable(table, map, cards) {
  if (!table) return;
  const body = table.tBodies[0];
  const rows = [...body.rows].map((row) => ({
    row,
    keys: [...row.cells].map((cell) => ("value" in cell.dataset ? Number(cell.dataset.value) : cell.textContent.trim())),
    text: row.textContent.toLowerCase(),
  }));
  const headings = [...table.tHead.rows[0].cells];

  function sort(column, descending) {
    const sign = descending ? -1 : 1;
    rows.sort((a, b) => sign * compare(a.keys[column], b.keys[column]));
    const sorted = document.createDocumentFragment(); // all rows move at once: one layout, however many there are
    sorted.append(...rows.map((entry) => entry.row));
    body.append(sorted);
    headings.forEach((heading, k) => {
      if (k === column) heading.setAttribute("aria-sort", descending ? "descending" : "ascending");
      else heading.removeAttribute("aria-sort");
    });
  }

  headings.forEach((heading, column) => {
    const button = heading.querySelector("button");
    button?.addEventListener("click", () => sort(column, heading.getAttribute("aria-sort") === "ascending"));
  });

  const filter = document.getElementById("object-filter");
  const count = document.getElementById("object-count");
  filter?.addEventListener("input", () => {
    const words = filter.value.toLowerCase().split(/\s+/).filter(Boolean);
    let shown = 0;
    for (const { row, text } of rows) {
      row.hidden = !words.every((word) => text.includes(word));
      shown += !row.hidden;
    }
    count.textContent = `${shown} of ${rows.length} shown`;
  });

  table.addEventListener("click", (event) => {
    const { object, action } = event.target.closest("[data-action]")?.dataset ?? {};
    if (!object) return;
    event.preventDefault();
    if (action === "card") cards.open(object);
    if (action === "map") map?.show(object);
  });
}

function compare(a, b) {
  if (typeof a === "number" && typeof b === "number") return Number.isNaN(a) - Number.isNaN(b) || a - b;
  return order.compare(a, b);
}
