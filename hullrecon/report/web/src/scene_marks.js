// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
import { BufferGeometry, CanvasTexture, Group, Line, LineBasicMaterial, LineLoop, SRGBColorSpace, Sprite, SpriteMaterial, Vector3 } from "three";

const OBJECT = "#c8541b";
const REACH_PX = 22;

/** Path and objects; nearest() tells which object's number a point of the screen hits. */
export function makeMarks(data) {
  const objects = new Group();
  const numbers = data.scene.objects.map((found) => {
    const normal = new Vector3(...found.normal);
    const at = new Vector3(...found.at).addScaledVector(normal, 0.12);
    const sprite = new Sprite(new SpriteMaterial({ map: numbered(found.id), sizeAttenuation: false, depthTest: false }));
    sprite.position.copy(at);
    sprite.scale.setScalar(0.04);
    sprite.renderOrder = 3;
    const stem = line([new Vector3(...found.at), at], OBJECT);
    objects.add(sprite, stem);
    if (found.outline.length > 2) {
      const ring = found.outline.map((p) => new Vector3(...p).addScaledVector(normal, 0.01));
      const loop = new LineLoop(new BufferGeometry().setFromPoints(ring), new LineBasicMaterial({ color: OBJECT, depthTest: false, transparent: true }));
      loop.renderOrder = 2;
      objects.add(loop);
    }
    return { id: found.id, sprite, normal };
  });

  const path = new Group();
  path.add(line(data.scene.path.map((p) => new Vector3(...p)), "#14304d"));
  const group = new Group();
  group.add(objects, path);

  return {
    group,
    layers: { objects, path },
    /** Numbers of objects on the far side are hidden. */
    face(camera) {
      const away = new Vector3();
      for (const { sprite, normal } of numbers) sprite.visible = away.copy(camera.position).sub(sprite.position).dot(normal) > 0;
    },
    nearest(camera, x, y, width, height) {
      if (!objects.visible) return null;
      let best = null;
      let least = REACH_PX;
      for (const { id, sprite } of numbers) {
        if (!sprite.visible) continue;
        const at = sprite.position.clone().project(camera);
        const distance = Math.hypot(((at.x + 1) / 2) * width - x, ((1 - at.y) / 2) * height - y);
        if (at.z < 1 && distance < least) [best, least] = [id, distance];
      }
      return best;
    },
    /** Where an object's number stands on the screen, in CSS pixels of the view. */
    numbers,
  };
}

function line(points, colour) {
  const made = new Line(new BufferGeometry().setFromPoints(points), new LineBasicMaterial({ color: colour, transparent: true }));
  made.renderOrder = 1;
  return made;
}

function numbered(id) {
  const canvas = document.createElement("canvas");
  canvas.width = canvas.height = 96;
  const pen = canvas.getContext("2d");
  pen.fillStyle = OBJECT;
  pen.strokeStyle = "#fff";
  pen.lineWidth = 7;
  pen.beginPath();
  pen.arc(48, 48, 43, 0, 7);
  pen.fill();
  pen.stroke();
  pen.fillStyle = "#fff";
  pen.font = `600 ${String(id).length > 2 ? 38 : 50}px "Segoe UI", "DejaVu Sans", Arial, sans-serif`;
  pen.textAlign = "center";
  pen.textBaseline = "middle";
  pen.fillText(String(id), 48, 51);
  const texture = new CanvasTexture(canvas);
  texture.colorSpace = SRGBColorSpace;
  return texture;
}
