/** The site's files as tests read them: from the disk, with the modules that the page uses. */

import { readFileSync } from "node:fs";
import { gunzipSync } from "node:zlib";

import { Ground } from "../src/ground";
import { Body, type Mujoco, openMujoco } from "../src/physics";
import { openRuntime, Policy } from "../src/policy";
import type { GroundFile, Index, Scene, Specification } from "../src/site";

export function read(path: string): Uint8Array<ArrayBuffer> {
  return new Uint8Array(gunzipSync(readFileSync(new URL(`../public/${path}.gz`, import.meta.url))));
}

export function readJson<T>(path: string): T {
  return JSON.parse(new TextDecoder().decode(read(path))) as T;
}

export const specification = readJson<Specification>("data/specification.json");
export const index = readJson<Index>("data/index.json");

export function mujocoOfTheSite(): Promise<Mujoco> {
  return openMujoco(read("wasm/mujoco.wasm").buffer);
}

export function groundNamed(name: string): Ground {
  const file = readJson<GroundFile>(`data/grounds/${name}.json`);
  return new Ground(file, file.surface ? new Float32Array(read(`data/grounds/${name}.bin`).buffer) : null);
}

export function bodyOn(mujoco: Mujoco, ground: Ground, body: string, lock: string, groundName: string): Body {
  const scene = readJson<Scene>(`data/scenes/${body}-${lock}-${groundName}.json`);
  return new Body(mujoco, scene, specification, ground.shares);
}

export async function policyOf(base: string, names: string[]): Promise<Policy> {
  openRuntime(read("wasm/onnxruntime.wasm").buffer);
  const policy = new Policy(base, index.bases[base], async (path) => read(path), specification.heightmap.size);
  await policy.add(names);
  return policy;
}
