/** The page's physics and observations are the environments' own: ten worlds that Python recorded, replayed. */

import { readFileSync } from "node:fs";
import { gunzipSync } from "node:zlib";

import { beforeAll, describe, expect, test } from "vitest";

import type { Mujoco } from "../src/physics";
import { headingOf } from "../src/rotations";
import { Walker } from "../src/walker";
import { bodyOn, groundNamed, mujocoOfTheSite, policyOf, specification } from "./site";

interface World {
  policy: string;
  base: string;
  body: string;
  lock: string;
  ground: string;
  qpos: number[][];
  qvel: number[][];
  actions: number[][];
  observations: number[][];
  heightmaps: (number[] | null)[];
  fallen: boolean[];
  goals: [number, number, number][];
}

const file = new URL("replay.json.gz", import.meta.url);
const worlds = JSON.parse(gunzipSync(readFileSync(file)).toString()) as World[];
const POSITIONS = 1e-6;
const OBSERVATIONS = 1e-5;
/** Steps after which a replay goes on from the recorded state: rounding grows tenfold in about 30 of them. */
const SYNCHRONISED = 100;
/** MuJoCo's contacts on heightfields jump with the last bit, in Python alone, too: from one step to the next, at most. */
const ON_HILLS = { synchronised: 1, positions: 0.05 };

let mujoco: Mujoco;
beforeAll(async () => {
  mujoco = await mujocoOfTheSite();
});

function worst(found: ArrayLike<number>, wanted: ArrayLike<number>): number {
  expect(found.length).toBe(wanted.length);
  let most = 0;
  for (let i = 0; i < wanted.length; i++) most = Math.max(most, Math.abs(found[i] - wanted[i]));
  return most;
}

/** The recorded actions are those of the joints that this body has. */
function asPolicys(action: number[], joints: string[]): Float64Array {
  const whole = new Float64Array(specification.joints.length);
  joints.forEach((joint, i) => (whole[specification.joints.indexOf(joint)] = action[i]));
  return whole;
}

function replayed(world: World, synchronise: number) {
  const ground = groundNamed(world.ground);
  const body = bodyOn(mujoco, ground, world.body, world.lock, world.ground);
  const walker = new Walker(body, ground, world.base);
  const found = { positions: 0, observations: 0, heights: 0, falls: 0 };
  world.qpos.forEach((qpos, step) => {
    found.positions = Math.max(found.positions, worst(walker.motion.data.qpos, qpos));
    if (step > 0 && step % synchronise === 0) walker.placeAt(qpos, world.qvel[step]);
    walker.goal = { target: [world.goals[step][0], world.goals[step][1]], speed: world.goals[step][2] };
    walker.look();
    found.observations = Math.max(found.observations, worst(walker.observation, world.observations[step]));
    found.falls += Number(walker.fallen !== world.fallen[step]);
    const heights = world.heightmaps[step];
    if (heights) {
      walker.lookAround();
      found.heights = Math.max(found.heights, worst(walker.heightmap, heights));
    }
    walker.motion.act(asPolicys(world.actions[step], body.scene.joints));
    for (let i = 0; i < specification.physics_steps; i++) walker.tick();
    walker.remember();
  });
  walker.close();
  body.close();
  return found;
}

test("there are ten worlds of 300 steps, on every ground, with another body and with a lock", () => {
  expect(worlds.map((world) => world.actions.length)).toEqual(Array(10).fill(301));
  expect(new Set(worlds.map((world) => world.ground))).toEqual(new Set(["flat", "ice", "hills", "blocks"]));
});

describe.each(worlds.map((world) => [`${world.policy}, ${world.body}, ${world.lock}, ${world.ground}`, world] as const))(
  "%s",
  (_, world) => {
    test("positions and observations are the environment's", () => {
      const onHills = world.ground === "hills";
      const found = replayed(world, onHills ? ON_HILLS.synchronised : SYNCHRONISED);
      console.log(found, "without going back to the recorded states:", replayed(world, Infinity).positions);
      expect(found.positions).toBeLessThan(onHills ? ON_HILLS.positions : POSITIONS);
      expect(found.observations).toBeLessThan(OBSERVATIONS);
      expect(found.heights).toBeLessThan(OBSERVATIONS);
      expect(found.falls).toBe(0);
    });
  },
);

test("the policies' actions are the environment's, up to the weights' half precision", async () => {
  for (const world of [worlds[0], worlds[1], worlds[4], worlds[7]]) {
    const names = world.policy === world.base ? [] : [world.policy];
    const policy = await policyOf(world.base, names);
    const heights = new Float32Array(world.heightmaps[100]!);
    const observation = new Float32Array(world.observations[100]);
    const action = await policy.act(observation, heights, [Object.fromEntries(names.map((name) => [name, 1]))]);
    expect(worst(action, world.actions[100])).toBeLessThan(5e-3);
    await policy.close();
  }
});

test("headings are those of the root", () => {
  expect(headingOf([Math.cos(0.4), 0, 0, Math.sin(0.4)])).toBeCloseTo(0.8, 12);
});
