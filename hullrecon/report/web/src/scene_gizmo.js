// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
import { ArrowHelper, CanvasTexture, OrthographicCamera, SRGBColorSpace, Scene, Sprite, SpriteMaterial, Vector3 } from "three";

const SIZE_PX = 120;

/** Arrows to the bow and upwards, in the lower right corner of the view. */
export function makeGizmo(document_) {
  const scene = new Scene();
  const camera = new OrthographicCamera(-2, 2, 2, -2, 0.1, 10);
  const arrows = [
    [new Vector3(...document_.forward), document_.forward_name, "#b3261e"],
    [new Vector3(...document_.up), "up", "#174a7c"],
  ];
  for (const [direction, name, colour] of arrows) {
    scene.add(new ArrowHelper(direction, new Vector3(), 1, colour, 0.32, 0.2));
    const label = new Sprite(new SpriteMaterial({ map: word(name, colour), depthTest: false }));
    label.position.copy(direction).multiplyScalar(1.3);
    label.scale.set(1.1, 0.55, 1);
    scene.add(label);
  }
  return {
    render(renderer, viewer, canvas) {
      camera.up.copy(viewer.up);
      viewer.getWorldDirection(camera.position).multiplyScalar(-5);
      camera.lookAt(0, 0, 0);
      renderer.setViewport(canvas.clientWidth - SIZE_PX - 6, 6, SIZE_PX, SIZE_PX);
      renderer.clearDepth();
      renderer.render(scene, camera);
      renderer.setViewport(0, 0, canvas.clientWidth, canvas.clientHeight);
    },
  };
}

function word(text, colour) {
  const canvas = document.createElement("canvas");
  [canvas.width, canvas.height] = [128, 64];
  const pen = canvas.getContext("2d");
  pen.font = '600 40px "Segoe UI", "DejaVu Sans", Arial, sans-serif';
  pen.textAlign = "center";
  pen.textBaseline = "middle";
  pen.lineWidth = 8;
  pen.strokeStyle = "#eef3f7";
  pen.strokeText(text, 64, 32);
  pen.fillStyle = colour;
  pen.fillText(text, 64, 32);
  const texture = new CanvasTexture(canvas);
  texture.colorSpace = SRGBColorSpace;
  return texture;
}
