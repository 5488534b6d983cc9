// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
// Prints what the Khronos validator says of a .glb, as JSON.
import { readFileSync } from "node:fs";
import { validateBytes } from "gltf-validator";

console.log(JSON.stringify(await validateBytes(new Uint8Array(readFileSync(process.argv[2])))));
