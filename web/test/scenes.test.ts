/** Every choice of body, lock and ground gives a scene that can be simulated. */

import { beforeAll, expect, test } from "vitest";

import { Ground } from "../src/ground";
import type { Mujoco } from "../src/physics";
import { Walker } from "../src/walker";
import { bodyOn, groundNamed, index, mujocoOfTheSite, specification } from "./site";

let mujoco: Mujoco;
beforeAll(async () => {
  mujoco = await mujocoOfTheSite();
});

test.each(Object.keys(index.grounds))("every body, and every lock with one of them, stands on %s", (groundName) => {
  const ground = groundNamed(groundName);
  const locks = Object.keys(index.locks);
  Object.keys(index.bodies).forEach((name, i) => {
    const lock = locks[i % locks.length];
    const body = bodyOn(mujoco, ground, name, lock, groundName);
    for (const base of Object.keys(index.bases)) {
      const walker = new Walker(body, ground, base);
      const [x, y] = walker.rootXY;
      expect(walker.history[2] - ground.floorAt(x, y), `${name} ${lock}`).toBeGreaterThan(0.7);
      for (let i = 0; i < specification.physics_steps; i++) walker.tick();
      walker.remember();
      expect(walker.falls, `${name} ${lock}`).toBe(0);
      walker.close();
    }
    body.close();
  });
});

test("a restart elsewhere on flat ground is the same start, moved and turned", () => {
  const ground = groundNamed("flat");
  const body = bodyOn(mujoco, ground, "plain", "plain", "flat");
  const walker = new Walker(body, ground, "walk");
  walker.aim(walker.heading, 1);
  walker.look();
  const before = walker.observation.slice();
  walker.restart({ xy: [3, -2], heading: 2.5 });
  walker.aim(2.5, 1);
  walker.look();
  expect(walker.rootXY[0]).toBeCloseTo(3, 5);
  expect(Math.abs(walker.heading)).toBeCloseTo(2.5, 5);
  walker.observation.forEach((value, i) => expect(value).toBeCloseTo(before[i], i === 780 || i === 781 ? 1 : 4));
  walker.close();
  body.close();
});

test.each(["flat", "hills"])("who stops acting falls on %s, and by how low it lies", (name) => {
  const { file, shares } = groundNamed(name);
  expect(file.fall_height).toBe(name === "hills" ? 0.15 : null);
  const falls = [file.fall_height, 1e-6].map((fall_height) => {
    const ground = new Ground({ ...file, fall_height }, shares);
    const body = bodyOn(mujoco, ground, "plain", "plain", name);
    const walker = new Walker(body, ground, "walk");
    for (let step = 0; step < 60; step++) {
      walker.motion.act(new Float64Array(specification.joints.length).fill(1));
      for (let i = 0; i < specification.physics_steps; i++) walker.tick();
      walker.remember();
    }
    const found = walker.falls > 0;
    walker.close();
    body.close();
    return found;
  });
  expect(falls).toEqual([true, false]);
});
