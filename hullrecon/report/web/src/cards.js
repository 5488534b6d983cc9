// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0

/** Opens an object's card in the dialog #card: a copy of the article #object-<id>, which the page holds for all readers. */
export function mountCards() {
  const dialog = document.getElementById("card");
  const body = dialog?.querySelector(".card-body");

  function open(id) {
    const article = document.getElementById(`object-${id}`);
    if (!article || !body) return;
    const copy = article.cloneNode(true);
    copy.removeAttribute("id");
    body.replaceChildren(copy);
    dialog.dataset.object = id;
    dialog.setAttribute("aria-label", `Object ${id}`);
    if (!dialog.open) dialog.showModal();
  }

  dialog?.addEventListener("click", (event) => {
    if (event.target === dialog) dialog.close(); // outside of the card
  });
  return { open };
}
