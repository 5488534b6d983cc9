// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
// Pictures lie as data URIs in script elements, so that a browser decodes none before it is shown.

/** Returns the data URI in the element of that id; also what a texture of the 3-D view is made of. */
export function pictureUri(id) {
  return document.getElementById(id).textContent.trim();
}

/** Returns a promise of {width, height, data} (RGBA bytes) of a picture. */
export async function readPixels(id) {
  const image = new Image();
  image.src = pictureUri(id);
  await image.decode();
  const canvas = document.createElement("canvas");
  canvas.width = image.naturalWidth;
  canvas.height = image.naturalHeight;
  const context = canvas.getContext("2d", { willReadFrequently: true });
  context.drawImage(image, 0, 0);
  return context.getImageData(0, 0, canvas.width, canvas.height);
}
